// A site that another server has, read only: nothing can be changed, and what is new is found.
#include "fleet/postgresql/postgres_replica.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "fleet/postgresql/limits.h"
#include "fleet/postgresql/postgres_store.h"
#include "fleet/postgresql/postgresql.h"
#include "tests/fleet/postgresql/postgres_server.h"
#include "tests/storage/records.h"

namespace isthmus::storage {
namespace {

using absl::StatusCode;
using ::testing::HasSubstr;

class PostgresReplicaTest : public ::testing::Test {
 protected:
  void SetUp() override {
    auto store = OpenPostgresStore(server_.url(), site_);
    ASSERT_TRUE(store.ok()) << store.status();
    owner_ = *std::move(store);
  }
  PostgresReplica Open() {
    auto replica = OpenPostgresReplica(server_.url(), site_);
    EXPECT_TRUE(replica.ok()) << replica.status();
    return replica.ok() ? *std::move(replica) : PostgresReplica();
  }
  absl::Status WhyNot() { return OpenPostgresReplica(server_.url(), site_).status(); }
  void Put(const WriteBatch& batch) {
    const absl::Status status = owner_->Write(batch);
    ASSERT_TRUE(status.ok()) << status;
  }
  // A map with two sessions, two submaps each.
  void PutMap() {
    Put({.sessions = {MakeSession("alice-1"), MakeSession("bob-1", "bob")},
         .trajectory = {{SessionId("alice-1"), MakeEntry(1)}, {SessionId("alice-1"), MakeEntry(2)}},
         .submaps = {MakeSubmap("alice-1", 0), MakeSubmap("alice-1", 1), MakeSubmap("bob-1", 0),
                     MakeSubmap("bob-1", 1)},
         .matches = {MakeMatch("alice-1", "bob-1")},
         .manual_decisions = {MakeManualDecision("alice-1", "bob-1")},
         .loops = {MakeLoop(1, "alice-1")},
         .anchors = {MakeAnchor("alice-1", 0)},
         .revision = MakeRevision(1)});
  }
  static StoreDelta Next(const PostgresReplica& replica) {
    auto delta = replica.follower->Next();
    EXPECT_TRUE(delta.ok()) << delta.status();
    return delta.ok() ? *std::move(delta) : StoreDelta();
  }
  static bool IsNothing(const StoreDelta& delta) {
    return !delta.sessions && delta.submaps.empty() && !delta.remaining &&
           delta.trajectory.empty() && !delta.matches && !delta.manual_decisions && !delta.loops &&
           !delta.anchors && !delta.datum && !delta.revision && !delta.has_events;
  }
  std::string schema() const { return SchemaOfSite(site_); }

  PostgresServer& server_ = PostgresServer::Shared();
  const std::string site_ = server_.NewSite();
  std::unique_ptr<MapStore> owner_;
};

TEST_F(PostgresReplicaTest, ReadsBesideTheOwnerAndWithoutOne) {
  PutMap();
  const PostgresReplica beside = Open();
  ASSERT_NE(beside.store, nullptr);
  EXPECT_EQ(beside.store->ListSubmaps(std::nullopt)->size(), 4u);
  Put({.sessions = {MakeSession("carol-1")}});  // The owner is in nobody's way.
  owner_ = nullptr;
  const PostgresReplica alone = Open();
  ASSERT_NE(alone.store, nullptr);
  EXPECT_EQ(alone.store->ListSessions()->size(), 3u);
  EXPECT_TRUE(alone.store->GetSubmap({SessionId("bob-1"), 1}).ok());
  // It is not in the way of the next owner, either.
  EXPECT_TRUE(OpenPostgresStore(server_.url(), site_).ok());
}

TEST_F(PostgresReplicaTest, RefusesToWrite) {
  PutMap();
  const PostgresReplica replica = Open();
  ASSERT_NE(replica.store, nullptr);
  EXPECT_EQ(replica.store->Write({.sessions = {MakeSession("carol-1")}}).code(),
            StatusCode::kFailedPrecondition);
  EXPECT_EQ(replica.store->DeleteSession(SessionId("alice-1")).code(),
            StatusCode::kFailedPrecondition);
  EXPECT_EQ(replica.store->PutFeatures(MakeFeatures({SessionId("bob-1"), 0}, "kind", "x")).code(),
            StatusCode::kFailedPrecondition);
  EXPECT_EQ(owner_->ListSessions()->size(), 2u);
}

// The connection itself cannot write, whatever the statement.
TEST_F(PostgresReplicaTest, ItsConnectionsCannotWrite) {
  PostgresTarget target;
  target.url = server_.url();
  target.schema = schema();
  target.is_read_only = true;
  const auto connection = PostgresConnection::Open(target);
  ASSERT_TRUE(connection.ok()) << connection.status();
  EXPECT_THAT(std::string((*connection)->Execute("DELETE FROM sessions").message()),
              HasSubstr("read-only transaction"));
}

TEST_F(PostgresReplicaTest, ARoleThatMayOnlyReadWillDo) {
  PutMap();
  const std::string role = "reader_of_" + site_;
  ASSERT_TRUE(server_.Execute("CREATE ROLE " + role + " LOGIN; GRANT USAGE ON SCHEMA " + schema() +
                              " TO " + role + "; GRANT SELECT ON ALL TABLES IN SCHEMA " + schema() +
                              " TO " + role));
  auto replica = OpenPostgresReplica(server_.url() + "&user=" + role, site_);
  ASSERT_TRUE(replica.ok()) << replica.status();
  EXPECT_EQ(Next(*replica).sessions->size(), 2u);
}

TEST_F(PostgresReplicaTest, RefusesASchemaThatIsNotItsOwn) {
  const std::string about = "UPDATE " + schema() + ".about SET version = version";
  ASSERT_TRUE(server_.Execute(about + " - 1"));
  EXPECT_EQ(WhyNot().code(), StatusCode::kFailedPrecondition);
  EXPECT_THAT(std::string(WhyNot().message()), HasSubstr("start the server that has the map"));
  ASSERT_TRUE(server_.Execute(about + " + 2"));
  EXPECT_EQ(WhyNot().code(), StatusCode::kFailedPrecondition);
  EXPECT_THAT(std::string(WhyNot().message()), HasSubstr("newer Isthmus"));
  ASSERT_TRUE(server_.Execute(about + " - 1"));
  EXPECT_TRUE(WhyNot().ok());
  const absl::Status nothing = OpenPostgresReplica(server_.url(), server_.NewSite()).status();
  EXPECT_EQ(nothing.code(), StatusCode::kNotFound);
  EXPECT_THAT(std::string(nothing.message()), HasSubstr("holds no map"));
}

// An owner of a newer program has come meanwhile.
TEST_F(PostgresReplicaTest, DoesNotFollowIntoANewerSchema) {
  PutMap();
  const PostgresReplica replica = Open();
  Next(replica);
  ASSERT_TRUE(server_.Execute("UPDATE " + schema() + ".about SET version = version + 1"));
  Put({.sessions = {MakeSession("carol-1")}});
  EXPECT_EQ(replica.follower->Next().status().code(), StatusCode::kFailedPrecondition);
  ASSERT_TRUE(server_.Execute("UPDATE " + schema() + ".about SET version = version - 1"));
  EXPECT_EQ(Next(replica).sessions->size(), 3u);
}

TEST_F(PostgresReplicaTest, TellsEverythingAtFirstAndThenWhatIsNew) {
  PutMap();
  const PostgresReplica replica = Open();
  const StoreDelta all = Next(replica);
  ASSERT_TRUE(all.sessions && all.matches && all.manual_decisions && all.loops && all.anchors);
  EXPECT_EQ(all.sessions->size(), 2u);
  EXPECT_EQ(all.submaps.size(), 4u);
  EXPECT_EQ(all.trajectory.size(), 2u);
  EXPECT_EQ(all.matches->size(), 1u);
  EXPECT_EQ(all.manual_decisions->size(), 1u);
  EXPECT_EQ(all.loops->size(), 1u);
  EXPECT_EQ(all.anchors->size(), 1u);
  ASSERT_TRUE(all.revision.has_value());
  EXPECT_EQ(all.revision->revision, 1);
  EXPECT_THAT(all.owner, HasSubstr("process " + std::to_string(getpid())));
  EXPECT_TRUE(IsNothing(Next(replica)));

  Put({.trajectory = {{SessionId("alice-1"), MakeEntry(3)}},
       .submaps = {MakeSubmap("alice-1", 2)}});
  const StoreDelta grown = Next(replica);
  ASSERT_EQ(grown.submaps.size(), 1u);
  EXPECT_EQ(grown.submaps[0].id, (SubmapId{SessionId("alice-1"), 2}));
  ASSERT_EQ(grown.trajectory.size(), 1u);
  EXPECT_EQ(grown.trajectory[0].second.sequence, 3u);
  EXPECT_FALSE(grown.sessions || grown.remaining || grown.matches || grown.loops || grown.revision);

  ASSERT_TRUE(owner_->PutFeatures(MakeFeatures({SessionId("bob-1"), 0}, "kind", "x")).ok());
  EXPECT_TRUE(IsNothing(Next(replica)));
}

// A row that is written again, another that comes as one goes: each table has as many rows as
// before.
TEST_F(PostgresReplicaTest, FindsWhatChangedInPlace) {
  PutMap();
  Put({.events = {MakeEvent(EventKind::kServerStarted, 1)}});
  const PostgresReplica replica = Open();
  Next(replica);
  Match match = MakeMatch("alice-1", "bob-1");
  match.confidence = 0.125;
  Put({.matches = {match}});
  StoreDelta delta = Next(replica);
  ASSERT_TRUE(delta.matches.has_value());
  EXPECT_EQ(delta.matches->at(0).confidence, 0.125);
  EXPECT_FALSE(delta.sessions || delta.loops || delta.anchors || delta.manual_decisions);

  Put({.anchors = {MakeAnchor("bob-1", 1)}, .removed_anchors = {{SessionId("alice-1"), 0}}});
  delta = Next(replica);
  ASSERT_TRUE(delta.anchors.has_value());
  ASSERT_EQ(delta.anchors->size(), 1u);
  EXPECT_EQ(delta.anchors->at(0).submap.session, SessionId("bob-1"));

  SessionRecord finished = MakeSession("bob-1", "bob");
  finished.state = SessionState::kFinished;
  Put({.sessions = {finished}});
  delta = Next(replica);
  ASSERT_TRUE(delta.sessions.has_value());
  EXPECT_EQ(delta.sessions->at(1).state, SessionState::kFinished);

  Put({.withdrawn_decisions = {{SessionId("alice-1"), SessionId("bob-1")}}, .datum = Datum()});
  delta = Next(replica);
  ASSERT_TRUE(delta.manual_decisions.has_value());
  EXPECT_TRUE(delta.manual_decisions->empty());
  ASSERT_TRUE(delta.datum.has_value());
  EXPECT_TRUE(delta.datum->has_value());

  Put({.events = {MakeEvent(EventKind::kServerStopped, 2)}});
  EXPECT_TRUE(Next(replica).has_events);
}

TEST_F(PostgresReplicaTest, TellsWhatIsGone) {
  PutMap();
  const PostgresReplica replica = Open();
  Next(replica);
  // The newest goes, and another comes: as many as before.
  ASSERT_TRUE(owner_->DeleteSession(SessionId("bob-1")).ok());
  Put({.sessions = {MakeSession("carol-1", "carol")},
       .submaps = {MakeSubmap("carol-1", 0), MakeSubmap("carol-1", 1)}});
  StoreDelta delta = Next(replica);
  ASSERT_TRUE(delta.sessions && delta.remaining && delta.matches && delta.manual_decisions);
  EXPECT_EQ(delta.sessions->size(), 2u);
  EXPECT_EQ(delta.submaps.size(), 2u);
  EXPECT_EQ(delta.remaining->size(), 4u);
  EXPECT_FALSE(delta.remaining->contains({SessionId("bob-1"), 1}));
  EXPECT_TRUE(delta.matches->empty());

  Put({.retired = {{SessionId("alice-1"), 0}}});
  delta = Next(replica);
  ASSERT_TRUE(delta.remaining.has_value());
  EXPECT_EQ(delta.remaining->size(), 3u);
  EXPECT_FALSE(delta.sessions);
}

// The trajectory of a session that ended, to its end, and not again.
TEST_F(PostgresReplicaTest, ReadsATrajectoryToItsEndOnce) {
  PutMap();
  const PostgresReplica replica = Open();
  Next(replica);
  SessionRecord finished = MakeSession("alice-1");
  finished.state = SessionState::kFinished;
  Put({.sessions = {finished}, .trajectory = {{SessionId("alice-1"), MakeEntry(3)}}});
  EXPECT_EQ(Next(replica).trajectory.size(), 1u);
  Put({.sessions = {MakeSession("carol-1")}, .trajectory = {{SessionId("carol-1"), MakeEntry(1)}}});
  const StoreDelta delta = Next(replica);
  ASSERT_EQ(delta.trajectory.size(), 1u);
  EXPECT_EQ(delta.trajectory[0].first, SessionId("carol-1"));
}

// A map of months is not read into memory at once; also of a session that has ended.
TEST_F(PostgresReplicaTest, ReadsLongTrajectoriesPieceByPiece) {
  SessionRecord finished = MakeSession("alice-1");
  finished.state = SessionState::kFinished;
  Put({.sessions = {finished}, .trajectory = {{SessionId("alice-1"), MakeEntry(1)}}});
  ASSERT_TRUE(server_.Execute("INSERT INTO " + schema() +
                              ".trajectory SELECT session, n, stamp_ns, submap_index, "
                              "T_odom_sensor FROM " +
                              schema() + ".trajectory, generate_series(2, " +
                              std::to_string(kEntriesAtOnce + 1) + ") AS n"));
  const PostgresReplica replica = Open();
  EXPECT_EQ(Next(replica).trajectory.size(), static_cast<size_t>(kEntriesAtOnce));
  const StoreDelta rest = Next(replica);
  ASSERT_EQ(rest.trajectory.size(), 1u);
  EXPECT_EQ(rest.trajectory[0].second.sequence, static_cast<uint64_t>(kEntriesAtOnce + 1));
  EXPECT_FALSE(rest.sessions || rest.revision);
  EXPECT_TRUE(IsNothing(Next(replica)));
}

TEST_F(PostgresReplicaTest, GoesOnWhereConnectionsWereCutAndWithTheNextOwner) {
  PutMap();
  const PostgresReplica replica = Open();
  Next(replica);
  owner_ = nullptr;
  ASSERT_TRUE(
      server_.Execute("SELECT pg_terminate_backend(pid) FROM pg_stat_activity WHERE "
                      "application_name LIKE '" +
                      schema() + " %'"));
  auto next = OpenPostgresStore(server_.url(), site_);
  ASSERT_TRUE(next.ok()) << next.status();
  owner_ = *std::move(next);
  Put({.submaps = {MakeSubmap("alice-1", 2)}});
  absl::StatusOr<StoreDelta> delta = replica.follower->Next();
  if (!delta.ok()) {  // The error tells it of the cut.
    EXPECT_EQ(delta.status().code(), StatusCode::kUnavailable);
    delta = replica.follower->Next();
  }
  ASSERT_TRUE(delta.ok()) << delta.status();
  EXPECT_EQ(delta->submaps.size(), 1u);
  EXPECT_FALSE(delta->sessions || delta->remaining || delta->matches);
  EXPECT_TRUE(replica.store->GetSubmap({SessionId("alice-1"), 2}).ok());
}

// As after a restore from a backup: another owner goes on from before what was read.
TEST_F(PostgresReplicaTest, SaysWhereTheDatabaseHasLessThanWasRead) {
  PutMap();
  const PostgresReplica replica = Open();
  Next(replica);
  const std::string back = "UPDATE " + schema() + ".owners SET last_commit = last_commit - 1";
  ASSERT_TRUE(server_.Execute(back));
  EXPECT_THAT(std::string(replica.follower->Next().status().message()),
              HasSubstr("less than was read"));
  owner_ = nullptr;
  auto next = OpenPostgresStore(server_.url(), site_);
  ASSERT_TRUE(next.ok()) << next.status();
  owner_ = *std::move(next);
  EXPECT_THAT(std::string(replica.follower->Next().status().message()),
              HasSubstr("restart this server"));
}

}  // namespace
}  // namespace isthmus::storage
