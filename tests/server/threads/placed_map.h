// A map in memory that is placed as it changes, for tests of the threads that work on it.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "core/clock.h"
#include "server/map/map_writer.h"
#include "server/threads/placement_thread.h"
#include "storage/memory_store.h"

namespace isthmus::server {

inline const SessionId kSession("alice-1");

// Round a square of 20 m, two submaps a side.
inline Pose SquareOf(uint32_t index) {
  const Pose side = Pose::FromXyzRpy(10, 0, 0, 0, 0, 0);
  const Pose corner = Pose::FromXyzRpy(10, 0, 0, 0, 0, M_PI / 2);
  Pose pose;
  for (uint32_t i = 0; i < index; ++i) pose = pose * (i % 2 == 0 ? side : corner);
  return pose;
}

class PlacedMapTest : public ::testing::Test {
 protected:
  // Starts placing a map of these records. Call once, first.
  void Begin(const storage::WriteBatch& records) {
    ASSERT_TRUE(store_->Write(records).ok());
    ASSERT_TRUE(map_.Load().ok());
    placement_.emplace(&map_, &activity_, store_.get(), &Clock::System(),
                       placement::PlacerOptions());
  }

  // The first session of the robot, as it is opened.
  static SessionRecord SessionOf(const std::string& robot) {
    SessionRecord record;
    record.id = SessionId(robot + "-1");
    record.robot = RobotId(robot);
    record.sensor = "vlp16";
    return record;
  }

  std::unique_ptr<storage::MapStore> store_ = storage::MakeMemoryStore();
  SubmapCache submaps_{store_.get(), size_t{1} << 30, nullptr};
  Activity activity_;
  MapWriter map_{store_.get(), &submaps_, &activity_, &Clock::System()};
  std::optional<PlacementThread> placement_;
};

}  // namespace isthmus::server
