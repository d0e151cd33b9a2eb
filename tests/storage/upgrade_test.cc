// Databases of older schemas, as programs before this one left them, open and answer the same.
#include <gtest/gtest.h>

#include <cmath>

#include "storage/records/pose_codec.h"
#include "storage/records/submap_codec.h"
#include "storage/sqlite/migrations.h"
#include "storage/sqlite/sqlite_store.h"
#include "tests/storage/records.h"
#include "tests/storage/schema13.h"
#include "tests/storage/temporary_folder.h"

namespace isthmus::storage {
namespace {

// With the columns that schema 3 had, and nothing of this program's but SQLite.
void WriteSchema3(const std::string& path) {
  auto database = SqliteConnection::Open(path);
  ASSERT_TRUE(database.ok()) << database.status();
  const std::vector<Migration> three(Migrations().begin(), Migrations().begin() + 3);
  ASSERT_TRUE(Migrate(**database, three).ok());
  for (const char* id : {"alice-1", "bob-1"}) {
    ASSERT_TRUE((*database)
                    ->Prepare("INSERT INTO sessions (id, robot, sensor, T_base_sensor, state, "
                              "created_ns, finished_ns) VALUES (?, 'r', 'vlp16', ?, 1, 5, 6)")
                    .Bind(std::string(id))
                    .BindBlob(PackPose(Pose()))
                    .Run()
                    .ok());
  }
  const absl::Status match =
      (*database)
          ->Prepare(
              "INSERT INTO matches (a, b, T_a_b, state, reason, detail, confidence, overlap, "
              "inliers, residual_m, free_space, comparisons, runner_up, matcher, submaps_a, "
              "submaps_b, computed_ns) VALUES (1, 2, ?, 'ACCEPTED', 'OK', 'good', 0.75, 0.4, "
              "1234, 0.02, NULL, 99999, -1, 'birds_eye', 3, 4, 42)")
          .BindBlob(PackPose(Pose::FromXyzRpy(1, 2, 3, 0.1, 0.2, 0.3)))
          .Run();
  ASSERT_TRUE(match.ok()) << match;
  ASSERT_TRUE((*database)
                  ->Execute("INSERT INTO match_stages VALUES (1, 2, 0, 'birds_eye', 12.5), "
                            "(1, 2, 1, 'vgicp', 3.25)")
                  .ok());
}

TEST(UpgradeTest, MatchesOfSchema3AnswerTheSame) {
  const TemporaryFolder folder;
  std::filesystem::create_directories(folder.path());
  WriteSchema3(folder.database());
  const auto store = OpenSqliteStore(folder.path());
  ASSERT_TRUE(store.ok()) << store.status();
  const auto matches = (*store)->ListMatches();
  ASSERT_TRUE(matches.ok()) << matches.status();
  ASSERT_EQ(matches->size(), 1u);
  const Match& match = matches->front();
  EXPECT_EQ(match.a, SessionId("alice-1"));
  EXPECT_EQ(match.b, SessionId("bob-1"));
  EXPECT_TRUE(Near(match.T_a_b, Pose::FromXyzRpy(1, 2, 3, 0.1, 0.2, 0.3)));
  EXPECT_EQ(match.state, MatchState::kAccepted);
  EXPECT_EQ(match.reason, MatchReason::kOk);
  EXPECT_EQ(match.detail, "good");
  EXPECT_EQ(match.confidence, 0.75);
  EXPECT_EQ(match.overlap, 0.4);
  EXPECT_EQ(match.inliers, 1234);
  EXPECT_EQ(match.residual_m, 0.02);
  EXPECT_TRUE(std::isnan(match.free_space));
  EXPECT_EQ(match.comparisons, 99999);
  EXPECT_EQ(match.runner_up, -1);
  EXPECT_EQ(match.matcher, GuessSource::kBirdsEye);
  EXPECT_EQ(match.submaps_a, 3u);
  EXPECT_EQ(match.submaps_b, 4u);
  EXPECT_EQ(match.computed_ns, 42);
  ASSERT_EQ(match.stages.size(), 2u);
  EXPECT_EQ(match.stages[1].ms, 3.25);
}

TEST(UpgradeTest, WhatSchema3DidNotKeepIsNotComputed) {
  const TemporaryFolder folder;
  std::filesystem::create_directories(folder.path());
  WriteSchema3(folder.database());
  const auto store = OpenSqliteStore(folder.path());
  ASSERT_TRUE(store.ok()) << store.status();
  const Match match = (*store)->ListMatches()->at(0);
  EXPECT_EQ(match.inlier_ratio, -1);
  EXPECT_EQ(match.shared_area_m2, -1);
  EXPECT_EQ(match.observability, -1);
  EXPECT_EQ(match.odometry_residual, -1);
  EXPECT_EQ(match.candidates, 0u);
  EXPECT_TRUE(match.edges.empty());
  EXPECT_TRUE(match.rivals.empty());
  // And takes new ones, edges included.
  ASSERT_TRUE((*store)->Write({.matches = {MakeMatch("alice-1", "bob-1")}}).ok());
  EXPECT_EQ((*store)->ListMatches()->at(0).edges.size(), 2u);
  EXPECT_EQ((*store)->ListMatches()->at(0).rivals.size(), 2u);
}

// Submaps whole, and revisions that place sessions only.
void WriteSchema4(const std::string& path) {
  auto database = SqliteConnection::Open(path);
  ASSERT_TRUE(database.ok()) << database.status();
  const std::vector<Migration> four(Migrations().begin(), Migrations().begin() + 4);
  ASSERT_TRUE(Migrate(**database, four).ok());
  const auto submap = MakeSubmap("alice-1", 0);
  const SubmapInfo info = Summarize(*submap);
  const auto run = [](Statement& statement) {
    const absl::Status status = statement.Run();
    ASSERT_TRUE(status.ok()) << status;
  };
  run((*database)
          ->Prepare("INSERT INTO sessions (id, robot, sensor, T_base_sensor, state, created_ns, "
                    "finished_ns) VALUES ('alice-1', 'alice', 'vlp16', ?, 1, 5, 6)")
          .BindBlob(PackPose(Pose())));
  run((*database)
          ->Prepare("INSERT INTO submaps (session, submap_index, T_odom_submap, first_sequence, "
                    "last_sequence, first_stamp_ns, last_stamp_ns, keyframe_count, point_count, "
                    "min_x, min_y, min_z, max_x, max_y, max_z) "
                    "VALUES (1, 0, ?, 1, 10, 100, 200, 3, ?, -4, -4, -4, 4, 4, 4)")
          .BindBlob(PackPose(submap->T_odom_submap))
          .Bind(info.point_count));
  run((*database)
          ->Prepare("INSERT INTO submap_blobs VALUES (1, ?)")
          .BindBlob(*EncodeSubmap(*submap, 0.001)));
  run((*database)
          ->Prepare("INSERT INTO trajectory VALUES (1, 7, 100, 0, ?)")
          .BindBlob(PackPose(Pose())));
  for (int64_t number = 41; number <= 42; ++number) {
    run((*database)
            ->Prepare("INSERT INTO revisions (revision, stamp_ns, cause) VALUES (?, 7, 'alice')")
            .Bind(number));
    run((*database)
            ->Prepare("INSERT INTO placements VALUES (?, 'alice-1', 0, 'alice-1', ?)")
            .Bind(number)
            .BindBlob(PackPose(Pose::FromXyzRpy(1, 2, 3, 0, 0, 1))));
  }
}

TEST(UpgradeTest, MapsOfSchema4AnswerTheSame) {
  const TemporaryFolder folder;
  std::filesystem::create_directories(folder.path());
  WriteSchema4(folder.database());
  const auto store = OpenSqliteStore(folder.path());
  ASSERT_TRUE(store.ok()) << store.status();
  const auto submap = (*store)->GetSubmap({SessionId("alice-1"), 0});
  ASSERT_TRUE(submap.ok()) << submap.status();
  EXPECT_EQ((*submap)->points.size(), 600u);
  EXPECT_TRUE((*submap)->drift_covariance.isZero(0));
  EXPECT_TRUE((*store)->ListLoops()->empty());
  EXPECT_TRUE((*store)->ListAnchors()->empty());
  const auto latest = (*store)->LatestRevision();
  ASSERT_TRUE(latest.ok()) << latest.status();
  EXPECT_EQ(latest->revision, 42);
  EXPECT_EQ(latest->cause, "alice");
  ASSERT_EQ(latest->placements.size(), 1u);
  EXPECT_TRUE(Near(latest->placements[0].T_map_odom, Pose::FromXyzRpy(1, 2, 3, 0, 0, 1)));
  EXPECT_TRUE(latest->placements[0].submaps.empty());
  ASSERT_EQ((*store)->ListRevisions(10)->size(), 2u);
  EXPECT_EQ((*store)->ListRevisions(10)->at(1).revision, 41);
}

// Their revisions moved sessions as a whole: nothing is known of single submaps.
TEST(UpgradeTest, HistoryOfSubmapsBeginsAfterSchema4) {
  const TemporaryFolder folder;
  std::filesystem::create_directories(folder.path());
  WriteSchema4(folder.database());
  const auto store = OpenSqliteStore(folder.path());
  ASSERT_TRUE(store.ok()) << store.status();
  const SessionId alice("alice-1");
  SubmapMove move;
  move.submap = {alice, 0};
  move.after = Pose::FromXyzRpy(4, 5, 6, 0, 0, 1);
  move.frame_after = alice;
  ASSERT_TRUE((*store)->Write({.revision = MakeRevision(43), .moves = {move}}).ok());
  EXPECT_EQ((*store)->ListMoves(42, 43)->size(), 1u);
  EXPECT_EQ((*store)->ListMoves(41, 43).status().code(), absl::StatusCode::kOutOfRange);
  ASSERT_EQ((*store)->LatestRevision()->placements[0].submaps.size(), 1u);
  EXPECT_EQ((*store)->ListRevisions(10)->size(), 3u);
  // And what there was can be retired.
  ASSERT_TRUE((*store)->Write({.retired = {{alice, 0}}}).ok());
  EXPECT_TRUE((*store)->ListSubmaps(alice)->empty());
  EXPECT_TRUE((*store)->GetTrajectory(alice)->empty());
}

// Sessions of one segment each, checkpoint and all.
void WriteSchema7(const std::string& path) {
  auto database = SqliteConnection::Open(path);
  ASSERT_TRUE(database.ok()) << database.status();
  const std::vector<Migration> seven(Migrations().begin(), Migrations().begin() + 7);
  ASSERT_TRUE(Migrate(**database, seven).ok());
  ASSERT_TRUE((*database)
                  ->Prepare("INSERT INTO sessions (id, robot, sensor, T_base_sensor, state, "
                            "created_ns, finished_ns, request_id) VALUES ('alice-1', 'alice', "
                            "'vlp16', ?, 0, 5, 0, 'wish')")
                  .BindBlob(PackPose(Pose()))
                  .Run()
                  .ok());
  ASSERT_TRUE((*database)->Execute("INSERT INTO checkpoints VALUES (1, 9, 7, 0, x'6f6c64')").ok());
}

TEST(UpgradeTest, SessionsOfSchema7AreFirstSegmentsAndTakeLaterOnes) {
  const TemporaryFolder folder;
  std::filesystem::create_directories(folder.path());
  WriteSchema7(folder.database());
  const auto store = OpenSqliteStore(folder.path());
  ASSERT_TRUE(store.ok()) << store.status();
  const SessionId alice("alice-1");
  const auto record = (*store)->GetSession(alice);
  ASSERT_TRUE(record.ok()) << record.status();
  EXPECT_EQ(record->segment, 1u);
  EXPECT_TRUE(record->first_segment.empty());
  EXPECT_EQ(record->request_id, "wish");
  EXPECT_EQ(record->scans, ScanCounts());
  EXPECT_EQ((*store)->GetCheckpoint(alice)->durable_sequence, 7u);
  SessionRecord second = MakeSession("alice-1.2");
  second.segment = 2;
  second.first_segment = alice;
  ASSERT_TRUE((*store)->Write({.sessions = {second}}).ok());
  ASSERT_TRUE((*store)->DeleteSession(alice).ok());
  EXPECT_TRUE((*store)->ListSessions()->empty());
}

TEST(UpgradeTest, Schema11HasNoEventsAndTakesThem) {
  const TemporaryFolder folder;
  std::filesystem::create_directories(folder.path());
  {
    auto database = SqliteConnection::Open(folder.database());
    ASSERT_TRUE(database.ok()) << database.status();
    const std::vector<Migration> eleven(Migrations().begin(), Migrations().begin() + 11);
    ASSERT_TRUE(Migrate(**database, eleven).ok());
  }
  const auto store = OpenSqliteStore(folder.path());
  ASSERT_TRUE(store.ok()) << store.status();
  EXPECT_EQ((*store)->ListEvents({})->newest, 0u);
  ASSERT_TRUE((*store)->Write({.events = {MakeEvent(EventKind::kServerStarted, 1)}}).ok());
  EXPECT_EQ((*store)->ListEvents({})->newest, 1u);
}

TEST(UpgradeTest, ContentsOfSubmapsAreNotKnownUntilTheyAreGiven) {
  const TemporaryFolder folder;
  std::filesystem::create_directories(folder.path());
  WriteSchema4(folder.database());
  const auto store = OpenSqliteStore(folder.path());
  ASSERT_TRUE(store.ok()) << store.status();
  const SubmapId id{SessionId("alice-1"), 0};
  EXPECT_EQ((*store)->ListSubmaps(std::nullopt)->at(0).content, 0u);
  const uint64_t content = ContentOf(**(*store)->GetSubmap(id));
  ASSERT_TRUE((*store)->Write({.contents = {{id, content}, {{id.session, 7}, 5}}}).ok());
  EXPECT_EQ((*store)->ListSubmaps(std::nullopt)->at(0).content, content);
  ASSERT_TRUE((*store)->Write({.contents = {{id, content + 1}}}).ok());
  EXPECT_EQ((*store)->ListSubmaps(std::nullopt)->at(0).content, content);
}

TEST(UpgradeTest, MatchingGoesOnWhereItWasInSchema13) {
  const TemporaryFolder folder;
  std::filesystem::create_directories(folder.path());
  auto database = SqliteConnection::Open(folder.database());
  ASSERT_TRUE(database.ok()) << database.status();
  const std::vector<Migration> thirteen(Migrations().begin(), Migrations().begin() + 13);
  ASSERT_TRUE(Migrate(**database, thirteen).ok());
  FillSchema13(**database);
  const auto store = OpenSqliteStore(folder.path());
  ASSERT_TRUE(store.ok()) << store.status();
  ExpectProgressOfSchema13(**store, **database);
}

}  // namespace
}  // namespace isthmus::storage
