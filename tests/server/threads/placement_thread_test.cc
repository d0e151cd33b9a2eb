// The map after a placement that went wrong.
#include "server/threads/placement_thread.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <new>
#include <string>
#include <vector>

#include "tests/server/threads/placed_map.h"

namespace isthmus::server {
namespace {

class BrokenClock : public Clock {
 public:
  int64_t NowNs() const override {
    if (is_broken) throw std::bad_alloc();
    return 1;
  }
  std::atomic<bool> is_broken = true;
};

class PlacementThreadTest : public PlacedMapTest {
 protected:
  void AddPoint(uint32_t index) {
    auto submap = std::make_shared<Submap>();
    submap->id = {SessionId("alice-1"), index};
    submap->robot = RobotId("alice");
    submap->first_sequence = submap->last_sequence = index + 1;
    submap->keyframes = {{index + 1, 1, Pose()}};
    submap->points = {{1, 2, 3, 0, 0}};
    FinishedSubmap finished;
    finished.submap = submap;
    finished.trajectory = {{index + 1, 1, Pose(), index}};
    ASSERT_TRUE(map_.AddSubmap(SessionId("alice-1"), finished).ok());
    map_.WaitUntilPlaced();
  }
};

TEST_F(PlacementThreadTest, WhatIsThrownIsNamedAndTriedAgainWithTheNextChange) {
  ASSERT_TRUE(store_->Write({.sessions = {SessionOf("alice")}}).ok());
  ASSERT_TRUE(map_.Load().ok());
  BrokenClock clock;
  std::vector<std::string> problems;
  placement_.emplace(&map_, &activity_, store_.get(), &clock, placement::PlacerOptions(),
                     [&](const std::string& problem) { problems.push_back(problem); });
  AddPoint(0);
  EXPECT_EQ(map_.view()->revision->revision, 0);
  clock.is_broken = false;
  AddPoint(1);
  EXPECT_EQ(map_.view()->revision->revision, 1);
  EXPECT_EQ(map_.view()->PlacedSubmaps().size(), 2u);
  placement_.reset();
  ASSERT_EQ(problems.size(), 1u);
  EXPECT_THAT(problems[0], ::testing::HasSubstr("alice-1/0"));
  EXPECT_THAT(problems[0], ::testing::HasSubstr("not enough memory"));
}

}  // namespace
}  // namespace isthmus::server
