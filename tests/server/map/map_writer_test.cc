// The one place where the map changes: the order of storing and showing, and who waits for whom.
#include "server/map/map_writer.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "storage/forwarding_store.h"
#include "storage/memory_store.h"

namespace isthmus::server {
namespace {

// Calls a hook before it writes, and fails when told to.
class HookedStore : public storage::ForwardingStore {
 public:
  HookedStore() : ForwardingStore(storage::MakeMemoryStore()) {}

  std::function<void()> before_write = [] {};
  bool fails = false;

  absl::Status Write(const storage::WriteBatch& batch) override {
    before_write();
    return fails ? absl::ResourceExhaustedError("disk full") : ForwardingStore::Write(batch);
  }
};

const SessionId kAlice("alice-1"), kBob("bob-1");

FinishedSubmap MakeFinished(const SessionId& session, uint32_t index) {
  auto submap = std::make_shared<Submap>();
  submap->id = {session, index};
  submap->robot = RobotId(session.value().substr(0, session.value().find('-')));
  submap->keyframes = {{index + 1, index + 1, Pose()}};
  submap->points = {{1, 2, 3, 0, 0}};
  submap->first_sequence = submap->last_sequence = index + 1;
  FinishedSubmap finished;
  finished.trajectory = {{index + 1, index + 1, Pose(), index}};
  finished.submap = submap;
  return finished;
}

Match MakeMatch() {
  Match match;
  match.a = kAlice;
  match.b = kBob;
  match.reason = MatchReason::kOk;
  return match;
}

class MapWriterTest : public testing::Test {
 protected:
  MapWriterTest() {
    std::vector<SessionRecord> records(2);
    records[0].id = kAlice;
    records[0].robot = RobotId("alice");
    records[1].id = kBob;
    records[1].robot = RobotId("bob");
    for (SessionRecord& record : records) record.sensor = "vlp16";
    EXPECT_TRUE(map_.Load().ok());
    EXPECT_TRUE(map_.PutSessions(records).ok());
  }

  HookedStore store_;
  SubmapCache submaps_{&store_, size_t{1} << 30, nullptr};
  Activity activity_;
  MapWriter map_{&store_, &submaps_, &activity_, &Clock::System()};
};

TEST_F(MapWriterTest, WhatCannotBeStoredIsNotShown) {
  store_.fails = true;
  const MapWriter::View before = map_.view();
  EXPECT_FALSE(map_.AddSubmap(kAlice, MakeFinished(kAlice, 0)).ok());
  EXPECT_FALSE(map_.PutMatch(MakeMatch()).ok());
  EXPECT_EQ(map_.view(), before);
}

// A record that was damaged on the disk; the submaps behind it keep their numbers.
TEST_F(MapWriterTest, ASubmapWhosePoseIsNoPoseIsNamedAndLeftOut) {
  class Damaged : public storage::ForwardingStore {
   public:
    using ForwardingStore::ForwardingStore;
    absl::StatusOr<std::vector<SubmapInfo>> ListSubmaps(
        const std::optional<SessionId>& session) const override {
      auto infos = ForwardingStore::ListSubmaps(session);
      for (SubmapInfo& info : *infos) {
        if (info.id.index == 1) info.T_odom_submap = Pose(Eigen::Vector3d::Constant(NAN));
      }
      return infos;
    }
  };
  auto memory = storage::MakeMemoryStore();
  {
    SubmapCache submaps(memory.get(), 1 << 20, nullptr);
    MapWriter map(memory.get(), &submaps, &activity_, &Clock::System());
    SessionRecord record;
    record.id = kAlice;
    record.robot = RobotId("alice");
    record.sensor = "vlp16";
    ASSERT_TRUE(map.Load().ok());
    ASSERT_TRUE(map.PutSessions({record}).ok());
    for (uint32_t i = 0; i < 3; ++i) {
      ASSERT_TRUE(map.AddSubmap(kAlice, MakeFinished(kAlice, i)).ok());
    }
  }
  Damaged store(std::move(memory));
  std::vector<SubmapId> damaged;
  SubmapCache submaps(&store, 1 << 20,
                      [&](const SubmapId& id, const std::string&) { damaged.push_back(id); });
  MapWriter map(&store, &submaps, &activity_, &Clock::System());
  ASSERT_TRUE(map.Load().ok());
  ASSERT_EQ(damaged.size(), 1u);
  EXPECT_EQ(damaged[0], (SubmapId{kAlice, 1}));
  EXPECT_EQ(submaps.Outline({kAlice, 1}), nullptr);
  EXPECT_NE(submaps.Outline({kAlice, 2}), nullptr);
  EXPECT_EQ(map.view()->Find(kAlice)->next_index(), 3u);
}

// Records that no store takes, but a damaged file may hold.
TEST_F(MapWriterTest, RecordsThatBreakTheRulesAreNamedAndLeftOut) {
  class Damaged : public storage::ForwardingStore {
   public:
    using ForwardingStore::ForwardingStore;
    absl::StatusOr<std::optional<Datum>> GetDatum() const override {
      return Datum{.latitude_deg = 48, .longitude_deg = -INFINITY};
    }
    absl::StatusOr<std::vector<Match>> ListMatches() const override {
      Match match = MakeMatch();
      match.T_a_b = Pose(Eigen::Vector3d::Constant(NAN));
      return std::vector<Match>{match};
    }
    absl::StatusOr<std::vector<SessionRecord>> ListSessions() const override {
      auto records = ForwardingStore::ListSessions();
      if (segment_of_none) (*records)[1].first_segment = kAlice;
      return records;
    }
    bool segment_of_none = false;
  };
  auto memory = storage::MakeMemoryStore();
  std::vector<SessionRecord> records(2);
  records[0].id = kAlice;
  records[1].id = kBob;
  ASSERT_TRUE(memory->Write({.sessions = records}).ok());
  Damaged store(std::move(memory));
  std::vector<std::string> problems;
  const auto note = [&](const std::string& problem) { problems.push_back(problem); };
  SubmapCache submaps(&store, 1 << 20, nullptr);
  MapWriter map(&store, &submaps, &activity_, &Clock::System());
  ASSERT_TRUE(map.Load(note).ok());
  ASSERT_EQ(problems.size(), 2u);
  EXPECT_NE(problems[0].find("match alice-1 ~ bob-1"), std::string::npos) << problems[0];
  EXPECT_NE(problems[1].find("datum"), std::string::npos) << problems[1];
  EXPECT_FALSE(map.view()->datum.has_value());
  EXPECT_TRUE(map.view()->matches.empty());
  // A first segment that says it is a later one of another session.
  store.segment_of_none = true;
  MapWriter again(&store, &submaps, &activity_, &Clock::System());
  const absl::Status refused = again.Load(note);
  EXPECT_TRUE(absl::IsDataLoss(refused)) << refused;
  EXPECT_NE(refused.message().find("session bob-1"), std::string::npos) << refused;
}

// Between writing and showing, something was thrown.
TEST_F(MapWriterTest, WhatWasWrittenButNotShownIsShownWhenItComesAgain) {
  const FinishedSubmap finished = MakeFinished(kAlice, 0);
  storage::WriteBatch batch;
  batch.submaps.push_back(finished.submap);
  ASSERT_TRUE(store_.Write(batch).ok());
  EXPECT_TRUE(map_.AddSubmap(kAlice, finished).ok());
  EXPECT_EQ(map_.view()->Find(kAlice)->submaps.size(), 1u);
  EXPECT_TRUE(absl::IsAlreadyExists(map_.AddSubmap(kAlice, finished)));
}

TEST_F(MapWriterTest, ReadersSeeTheMapWhileTheStoreIsWritten) {
  MapWriter::View seen;
  store_.before_write = [&] {
    seen = map_.view();
    EXPECT_TRUE(seen->Find(kAlice)->submaps.empty());
  };
  ASSERT_TRUE(map_.AddSubmap(kAlice, MakeFinished(kAlice, 0)).ok());
  ASSERT_NE(seen, nullptr);
  EXPECT_TRUE(seen->Find(kAlice)->submaps.empty()) << "a view never changes";
  EXPECT_EQ(map_.view()->Find(kAlice)->submaps.size(), 1u);
}

// A match takes a minute, in which its session may be deleted.
TEST_F(MapWriterTest, WhatASessionThatIsGoneWasFoundToBeIsIgnored) {
  bool is_first = true;
  store_.before_write = [&] {
    if (std::exchange(is_first, false)) {
      EXPECT_TRUE(map_.RemoveSession(kBob).ok());
    }
  };
  // Refused by the store, which no longer knows the session, or ignored.
  (void)map_.PutMatch(MakeMatch());
  EXPECT_TRUE(map_.view()->matches.empty());
  EXPECT_TRUE(map_.PutMatch(MakeMatch()).ok());
  EXPECT_TRUE(map_.view()->matches.empty());
  LoopClosure loop;
  loop.session = kBob;
  EXPECT_TRUE(map_.AddLoops({loop}).ok());
  EXPECT_TRUE(map_.view()->loops.empty());
  EXPECT_FALSE(map_.AddSubmap(kBob, MakeFinished(kBob, 0)).ok());
  EXPECT_EQ(submaps_.Get({kBob, 0}), nullptr);
}

TEST_F(MapWriterTest, ChangesAreTakenOnceWithTheViewThatHasThem) {
  (void)map_.TakeChanges();
  ASSERT_TRUE(map_.PutMatch(MakeMatch()).ok());
  for (uint32_t i = 0; i < 5; ++i) {
    ASSERT_TRUE(map_.AddSubmap(kAlice, MakeFinished(kAlice, i)).ok());
  }
  const MapWriter::ToPlace taken = map_.TakeChanges();
  EXPECT_EQ(taken.view, map_.view());
  ASSERT_EQ(taken.changes.causes.size(), 5u);
  EXPECT_EQ(taken.changes.causes.front(), "match alice-1 ~ bob-1 NOT_YET");
  EXPECT_EQ(taken.changes.causes.back(), "and more");
  EXPECT_EQ(taken.changes.matches.size(), 1u);
  EXPECT_TRUE(map_.TakeChanges().changes.causes.empty());
}

// Nothing of what several bring at once is lost, and no reader sees anything torn.
TEST_F(MapWriterTest, ManyWritersAndReadersAtOnce) {
  constexpr uint32_t kSubmaps = 200;
  std::atomic<bool> stop = false;
  std::thread reader([&] {
    uint64_t last = 0;
    while (!stop) {
      const MapWriter::View view = map_.view();
      EXPECT_GE(view->serial, last);
      last = view->serial;
      for (const auto& [id, session] : view->sessions) {
        EXPECT_EQ(session.points, session.submaps.size());
        EXPECT_EQ(session.next_index(), session.submaps.size());
      }
      for (const auto& [pair, match] : view->matches) {
        EXPECT_NE(view->EffectiveMatch(pair), nullptr);
      }
    }
  });
  std::vector<std::thread> writers;
  for (const SessionId& session : {kAlice, kBob}) {
    writers.emplace_back([&, session] {
      for (uint32_t i = 0; i < kSubmaps; ++i) {
        EXPECT_TRUE(map_.AddSubmap(session, MakeFinished(session, i)).ok());
      }
    });
  }
  writers.emplace_back([&] {
    for (uint32_t i = 0; i < kSubmaps; ++i) EXPECT_TRUE(map_.PutMatch(MakeMatch()).ok());
  });
  for (std::thread& writer : writers) writer.join();
  stop = true;
  reader.join();
  EXPECT_EQ(map_.view()->Find(kAlice)->submaps.size(), size_t{kSubmaps});
  EXPECT_EQ(map_.view()->Find(kBob)->submaps.size(), size_t{kSubmaps});
  EXPECT_EQ(map_.view()->matches.size(), 1u);
  // One for each, after the one for the start.
  EXPECT_EQ(map_.view()->graph_version, 1 + 3 * uint64_t{kSubmaps});
}

}  // namespace
}  // namespace isthmus::server
