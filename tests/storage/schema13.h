// The rows of a schema-13 database in which matching kept its progress as features, and what
// becomes of them.
#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <string>
#include <vector>

#include "core/io/crc32c.h"
#include "storage/map_store.h"
#include "storage/records/pose_codec.h"
#include "storage/sql/connection.h"

namespace isthmus::storage {

inline void ExpectRun(Statement& statement) {
  const absl::Status status = statement.Run();
  EXPECT_TRUE(status.ok()) << status;
}

// Into empty tables of that schema.
inline void FillSchema13(Connection& database) {
  Transaction transaction(database);
  ASSERT_TRUE(transaction.status().ok()) << transaction.status();
  int64_t session = 0, submap = 0;
  const auto add_session = [&](const std::string& id) {
    ExpectRun(
        database
            .Prepare("INSERT INTO sessions (key, id, robot, sensor, T_base_sensor, state, "
                     "created_ns, finished_ns, odometry, request_id, segment, scans_ok, "
                     "scans_degenerate, scans_lost, scans_rejected, when_behind, scans_skipped) "
                     "VALUES (?, ?, 'r', 'vlp16', ?, 1, 5, 6, '', '', 1, 0, 0, 0, 0, 0, 0)")
            .Bind(++session)
            .Bind(id)
            .BindBlob(PackPose(Pose())));
  };
  const auto add_submap = [&](uint32_t index) {
    ExpectRun(database
                  .Prepare("INSERT INTO submaps (key, session, submap_index, T_odom_submap, "
                           "first_sequence, last_sequence, first_stamp_ns, last_stamp_ns, "
                           "keyframe_count, point_count) VALUES (?, ?, ?, ?, 1, 2, 3, 4, 1, 0)")
                  .Bind(++submap)
                  .Bind(session)
                  .Bind(index)
                  .BindBlob(PackPose(Pose())));
  };
  const auto add_features = [&](const std::string& kind, const std::string& data) {
    ExpectRun(
        database.Prepare("INSERT INTO features (submap, kind, crc32c, data) VALUES (?, ?, ?, ?)")
            .Bind(submap)
            .Bind(kind)
            .Bind(io::Crc32c(data.data(), data.size()))
            .BindBlob(data));
  };
  add_session("alice-1");
  add_submap(0);
  add_features("loops-v1", "1");
  add_features("partners-v1", "40 10 20");
  add_submap(4);
  add_features("loops-v1", "1");
  add_features("partners-v1", "60 15 30");
  add_features("prepared-v1", "surface");
  add_session("bob-1");
  add_submap(1);
  add_features("partners-v1", "20 5");  // As the first programs wrote it.
  add_session("carol-1");
  add_submap(2);
  add_features("loops-v1", "1");
  add_features("partners-v1", "\xff damaged 99999999999999999999");
  add_session("dave-1");
  add_submap(0);
  const absl::Status filled = transaction.Commit();
  ASSERT_TRUE(filled.ok()) << filled;
}

// Once the database is of the newest schema.
inline void ExpectProgressOfSchema13(const MapStore& store, Connection& database) {
  const auto progress = store.ListMatchingProgress();
  ASSERT_TRUE(progress.ok()) << progress.status();
  EXPECT_EQ(*progress, (std::vector<MatchingProgress>{{SessionId("alice-1"), 5, 5, 60, 15, 30},
                                                      {SessionId("bob-1"), 0, 2, 20, 5, 10},
                                                      {SessionId("carol-1"), 3}}));
  EXPECT_EQ(store.GetFeatures({SessionId("alice-1"), 4}, "prepared-v1").value(), "surface");
  EXPECT_EQ(*database.ReadNumber("SELECT count(*) FROM features"), 1);
}

}  // namespace isthmus::storage
