// A server that only reads a map in PostgreSQL: after each change its map is the owner's.
#include <absl/strings/str_cat.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <memory>
#include <string>

#include "fleet/postgresql/postgres_replica.h"
#include "fleet/postgresql/postgres_store.h"
#include "tests/fleet/postgresql/postgres_server.h"
#include "tests/server/pipeline/robots.h"

namespace isthmus::server {
namespace {

using ::testing::HasSubstr;

class ReplicaTest : public ::testing::Test {
 protected:
  void SetUp() override {
    OpenOwner();
    OpenReplica();
  }
  void OpenOwner() {
    auto store = storage::OpenPostgresStore(database_.url(), site_);
    ASSERT_TRUE(store.ok()) << store.status();
    owner_ = std::move(Pipeline::Open(QuickOptions(), *std::move(store)).value());
  }
  void OpenReplica() {
    auto opened = storage::OpenPostgresReplica(database_.url(), site_);
    ASSERT_TRUE(opened.ok()) << opened.status();
    replica_ = std::move(
        Pipeline::OpenReplica(QuickOptions(), std::move(opened->store), std::move(opened->follower))
            .value());
  }
  void Stream(const SessionId& session, int from, int to, int robot = 0) {
    ASSERT_TRUE(drive_.Submit(*owner_, session, from, to, robot).ok());
  }
  // Too little for any match. Coordinates are as the store rounds them.
  void AddWall(const RobotId& robot) {
    Submap submap;
    submap.id = {Create(*owner_, robot), 0};
    submap.keyframes = {{0, 1'000, Pose()}, {0, 2'000, Pose(Eigen::Vector3d(1, 0, 0))}};
    for (int i = 0; i < 400; ++i) {
      const int column = i % 20, row = i / 20;
      submap.points.push_back({3.f, 0.25f * static_cast<float>(column),
                               0.25f * static_cast<float>(row), 1.f, uint16_t(i % 2)});
    }
    ASSERT_TRUE(owner_->sessions().AddSubmap(submap).ok());
  }

  // Tiles of equal content have equal versions.
  static std::string TilesOf(const ComposedMap& map) {
    std::string text;
    for (uint32_t component = 0; component < map.component_count(); ++component) {
      for (uint32_t level = 0; level < map.tile_levels(component); ++level) {
        for (const TileInfo& tile : map.Tiles(component, level)) {
          absl::StrAppend(&text, component, "/", level, "/", tile.id.x, "/", tile.id.y, ": ",
                          tile.points, " points, ", absl::Hex(tile.version), "\n");
        }
      }
    }
    return text;
  }
  static std::string RecordsOf(Pipeline& pipeline) {
    std::string text;
    for (const SessionStatus& session : pipeline.sessions().List()) {
      absl::StrAppend(&text, session.record.id.value(), " ",
                      session.record.state == SessionState::kActive ? "open " : "finished ",
                      session.submap_count, " submaps, ", session.point_count, " points, in ",
                      session.component.value_or(99), "\n");
    }
    const auto submaps = pipeline.reader().ListSubmaps(std::nullopt).value();
    for (const SubmapStatus& submap : submaps) {
      absl::StrAppend(&text, ToString(submap.info.id), " at ",
                      submap.T_map_submap.translation().x(), " in ", submap.component.value_or(99),
                      "\n");
    }
    const MatchGraph graph = pipeline.reader().GetMatchGraph();
    for (const MatchEdge& edge : graph.matches) {
      absl::StrAppend(&text, edge.match.a.value(), " ~ ", edge.match.b.value(), " ",
                      ToString(edge.match.state), " ", edge.in_tree,
                      edge.manual_decision ? " said" : "", "\n");
    }
    const auto loops = pipeline.reader().ListLoops(std::nullopt).value();
    for (const Loop& loop : loops) {
      absl::StrAppend(&text, "loop ", loop.loop.id, " ", loop.edges_used, "\n");
    }
    for (const RobotAnchor& anchor : pipeline.reader().ListAnchors(*pipeline.reader().View())) {
      absl::StrAppend(&text, "anchor of ", ToString(anchor.anchor.submap), "\n");
    }
    const auto revisions = pipeline.reader().ListRevisions(1000).value();
    for (const RevisionInfo& revision : revisions) {
      absl::StrAppend(&text, "revision ", revision.revision, ": ", revision.cause, "\n");
    }
    const MapInfo info = pipeline.GetMapInfo();
    absl::StrAppend(&text, info.datum ? info.datum->latitude_deg : -1, "\n");
    return text;
  }
  // After what the owner has at hand.
  void ExpectSame(const std::string& after) {
    owner_->WaitUntilIdle();
    replica_->WaitUntilIdle();
    const auto theirs = owner_->reader().Map(), ours = replica_->reader().Map();
    EXPECT_EQ(ours->revision(), theirs->revision()) << after;
    EXPECT_EQ(ours->robots(), theirs->robots()) << after;
    EXPECT_EQ(TilesOf(*ours), TilesOf(*theirs)) << after;
    EXPECT_EQ(RecordsOf(*replica_), RecordsOf(*owner_)) << after;
  }

  storage::PostgresServer& database_ = storage::PostgresServer::Shared();
  const std::string site_ = database_.NewSite();
  const Drive drive_{2};
  ManualClock clock_{1'000'000'000};
  std::unique_ptr<Pipeline> owner_, replica_;
};

TEST_F(ReplicaTest, ShowsEachRevisionAsTheOwnerDoes) {
  ExpectSame("nothing");
  const SessionId alice = Create(*owner_), bob = Create(*owner_, kBob);
  ExpectSame("two sessions");
  for (int scan = 0; scan < 20; scan += 5) {
    Stream(alice, scan, scan + 5);
    Stream(bob, scan, scan + 5, 1);
    ExpectSame("scans to " + std::to_string(scan + 5));
  }
  EXPECT_GT(replica_->reader().Map()->point_count(0), 1000u) << "else nothing was compared";
  ASSERT_TRUE(owner_->sessions().Finish(alice).ok());
  ASSERT_TRUE(owner_->sessions().Finish(bob).ok());
  ExpectSame("both finished");
  for (const RobotId& robot : {kAlice, kBob}) {
    const auto theirs = owner_->reader().GetTrajectory(robot, TrajectoryFrame::kMap);
    const auto ours = replica_->reader().GetTrajectory(robot, TrajectoryFrame::kMap);
    ASSERT_TRUE(theirs.ok() && ours.ok()) << theirs.status() << ours.status();
    ASSERT_EQ(ours->poses.size(), theirs->poses.size());
    EXPECT_EQ(ours->poses.back().pose.translation(), theirs->poses.back().pose.translation());
  }
  // One that begins now finds the same.
  OpenReplica();
  ExpectSame("a replica that was started late");
}

TEST_F(ReplicaTest, FollowsDecisionsAnUndoAndADeletedSession) {
  AddWall(kAlice);
  AddWall(kBob);
  ExpectSame("two walls");
  ASSERT_EQ(replica_->reader().Map()->component_count(), 2u);
  const auto joined =
      owner_->decisions().DecideMatch({.robot_a = kAlice,
                                       .robot_b = kBob,
                                       .kind = ManualDecisionKind::kSet,
                                       .T_a_b = Pose::FromXyzRpy(12, -3, 0.5, 0, 0, 1.2)});
  ASSERT_TRUE(joined.ok()) << joined.status();
  ExpectSame("a match by hand");
  EXPECT_EQ(replica_->reader().Map()->component_count(), 1u);
  const auto graph = replica_->ExportPoseGraph(0);
  ASSERT_TRUE(graph.ok()) << graph.status();
  EXPECT_EQ(*graph, *owner_->ExportPoseGraph(0));
  ASSERT_TRUE(owner_->decisions().UndoRevision(joined->revision, "a mistake").ok());
  ExpectSame("an undo");
  EXPECT_EQ(replica_->reader().Map()->component_count(), 2u);

  const SubmapId wall{owner_->sessions().List()[0].record.id, 0};
  ASSERT_TRUE(owner_->decisions()
                  .PutAnchor({.submap = wall,
                              .T_map_submap = Pose::FromXyzRpy(5, 5, 0, 0, 0, 0),
                              .sigma_xy_m = 0.1,
                              .sigma_z_m = 0.1,
                              .sigma_deg = 1,
                              .note = "a survey"})
                  .ok());
  ExpectSame("an anchor");
  ASSERT_TRUE(owner_->decisions().RemoveAnchor(wall).ok());
  ExpectSame("none any more");
  ASSERT_TRUE(owner_->decisions().SetDatum(Datum{.latitude_deg = 48, .longitude_deg = 11}).ok());
  ExpectSame("a datum");

  ASSERT_TRUE(owner_->sessions().Delete(wall.session).ok());
  ExpectSame("a deleted session");
  EXPECT_EQ(replica_->sessions().List().size(), 1u);
  EXPECT_EQ(replica_->reader().Map()->component_count(), 1u);
  EXPECT_EQ(replica_->sessions().Get(wall.session).status().code(), absl::StatusCode::kUnavailable);
}

// As the event log forgets in the end that there was one, its number is given again.
TEST_F(ReplicaTest, TellsASessionFromAnEarlierOneOfItsName) {
  AddWall(kAlice);
  ExpectSame("a wall");
  const SessionId session = owner_->sessions().List()[0].record.id;
  owner_ = nullptr;
  ASSERT_TRUE(
      storage::OpenPostgresStore(database_.url(), site_).value()->DeleteSession(session).ok());
  OpenOwner();
  ASSERT_EQ(Create(*owner_), session);
  Stream(session, 0, 10);
  ExpectSame("scans in another session");
  EXPECT_GT(replica_->reader().Map()->point_count(0), 1000u);
}

TEST_F(ReplicaTest, ServesWithoutTheOwnerAndFollowsTheNext) {
  AddWall(kAlice);
  ExpectSame("a wall");
  owner_ = nullptr;
  replica_->WaitUntilIdle();
  EXPECT_GT(replica_->reader().Map()->point_count(0), 0u);
  EXPECT_EQ(replica_->GetMapInfo().replica->problem, "");
  OpenOwner();
  AddWall(kBob);
  ExpectSame("a wall of the next owner's");
}

TEST_F(ReplicaTest, SaysHowFarBehindItIsWhilePostgresIsAway) {
  const auto database = storage::PostgresServer::Start();
  ASSERT_NE(database, nullptr);
  auto store = storage::OpenPostgresStore(database->url(), "");
  ASSERT_TRUE(store.ok()) << store.status();
  owner_ = std::move(Pipeline::Open(QuickOptions(), *std::move(store)).value());
  AddWall(kAlice);
  auto opened = storage::OpenPostgresReplica(database->url(), "");
  ASSERT_TRUE(opened.ok()) << opened.status();
  replica_ = std::move(Pipeline::OpenReplica(QuickOptions(), std::move(opened->store),
                                             std::move(opened->follower), clock_)
                           .value());
  ExpectSame("a wall");
  EXPECT_EQ(replica_->GetMapInfo().replica->behind_s, 0);
  EXPECT_THAT(replica_->GetLoad().replica->owner, HasSubstr("process"));
  database->Kill();
  clock_.Advance(60'000'000'000);
  // It notices when it next asks.
  do {
    replica_->WaitUntilIdle();
  } while (replica_->GetMapInfo().replica->problem.empty());
  const ReplicaState state = *replica_->GetMapInfo().replica;
  EXPECT_NEAR(state.behind_s, 60, 1e-6);
  EXPECT_THAT(state.problem, HasSubstr("the map is not followed"));
  EXPECT_GT(replica_->reader().Map()->point_count(0), 0u);
  ASSERT_TRUE(database->StartAgain());
  AddWall(kBob);
  while (!replica_->GetMapInfo().replica->problem.empty()) replica_->WaitUntilIdle();
  ExpectSame("a wall after that");
  EXPECT_EQ(replica_->GetMapInfo().replica->behind_s, 0);
}

TEST_F(ReplicaTest, RefusesEveryChange) {
  AddWall(kAlice);
  ExpectSame("a wall");
  const SessionId session = owner_->sessions().List()[0].record.id;
  const auto refused = [](const absl::Status& status) {
    EXPECT_EQ(status.code(), absl::StatusCode::kFailedPrecondition);
    EXPECT_THAT(std::string(status.message()), HasSubstr("replica"));
  };
  refused(replica_->sessions().Create({kBob, "vlp16"}).status());
  refused(replica_->sessions().Finish(session).status());
  refused(replica_->sessions().Delete(session));
  refused(replica_->sessions().SubmitScan(session, drive_.Upload(0)));
  refused(replica_->sessions().SetAckSink(session, nullptr));
  refused(replica_->sessions().AddSubmap(Submap()).status());
  refused(replica_->decisions().DecideMatch({.robot_a = kAlice, .robot_b = kBob}).status());
  refused(replica_->decisions().DecideLoop({}).status());
  refused(replica_->decisions().PutAnchor(Anchor()).status());
  refused(replica_->decisions().RemoveAnchor({session, 0}).status());
  refused(replica_->decisions().SetDatum(Datum()));
  refused(replica_->decisions().UndoRevision(1, "").status());
  replica_->events().Note({.kind = EventKind::kBackupMade});
  ExpectSame("nothing of that");
  EXPECT_EQ(replica_->events().List({})->newest, owner_->events().List({})->newest);
}

// Watchers of the map and of the event log are woken by what the owner does.
TEST_F(ReplicaTest, WakesThoseWhoWatch) {
  std::atomic<int> maps = 0, events = 0;
  const uint64_t map_handle = replica_->feed().OnChange([&] { ++maps; });
  const auto before = replica_->feed().Since({}, 0);
  ASSERT_TRUE(before.has_value());
  const uint64_t event_handle = replica_->events().OnStored([&] { ++events; });
  AddWall(kAlice);
  ExpectSame("a wall");
  EXPECT_GT(maps, 0);
  const auto step = replica_->feed().Since(before->mark, 0);
  ASSERT_TRUE(step.has_value());
  EXPECT_FALSE(step->restart);
  EXPECT_EQ(step->tiles.size(), 1u);
  EXPECT_GT(events, 0);
  EXPECT_EQ(replica_->events().List({})->events.size(), owner_->events().List({})->events.size());
  replica_->feed().Forget(map_handle);
  replica_->events().Forget(event_handle);
}

}  // namespace
}  // namespace isthmus::server
