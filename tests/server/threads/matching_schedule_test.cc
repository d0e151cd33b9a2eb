// The order of matching's jobs, as a table: the next job for a map and a ledger, and the number of
// pairs that wait.
#include "server/threads/matching_schedule.h"

#include <gtest/gtest.h>

#include <functional>
#include <memory>
#include <optional>
#include <ostream>
#include <string>
#include <vector>

#include "server/jobs/limits.h"
#include "server/matching/index/limits.h"

namespace isthmus::server {
namespace {

const SessionPair kAB{SessionId("a-1"), SessionId("b-1")};
const SessionPair kAC{SessionId("a-1"), SessionId("c-1")};

// A site with nothing but what a row of the table gives it. Sessions are "a-1", "b-1" ...
struct Site {
  // Gives the session so many submaps.
  void Has(const std::string& name, uint32_t submaps, uint64_t points = kLeastMatchedPoints) {
    SessionView session;
    if (const SessionView* before = view.Find(SessionId(name))) session = *before;
    session.record.id = SessionId(name);
    if (const size_t dot = name.find('.'); dot != std::string::npos) {
      session.record.segment = 2;
      session.record.first_segment = SessionId(name.substr(0, dot));
    }
    session.points = points;
    for (uint32_t k = 0; k < submaps; ++k) {
      SubmapInfo submap;
      submap.id = {SessionId(name), k};
      session.submaps.Set(k, submap);
    }
    view.sessions.Set(SessionId(name), session);
  }
  void Finish(const std::string& name) {
    SessionView session = *view.Find(SessionId(name));
    session.record.state = SessionState::kFinished;
    view.sessions.Set(SessionId(name), session);
  }
  // Several sessions of three submaps, more than are all matched, already compared.
  void HasMany() {
    for (size_t k = 0; k <= matching::kSearchAllSessions; ++k) {
      const std::string name = std::string(1, static_cast<char>('a' + k)) + "-1";
      Has(name, 3);
      ledger.indexed[SessionId(name)] = 3;
    }
  }
  void Tries(const SessionPair& pair) { ledger.attempts[pair] = AttemptNow(view, ledger, pair); }
  void Posts(const JobKey& key) { ledger.posted.emplace(key, Stopwatch()); }
  // Places the session's submaps along x, in a component of its own unless it is given another's.
  void Places(const std::string& name, uint32_t component, double y = 0) {
    auto revision = std::make_shared<MapRevision>(*view.revision);
    Placement placement;
    placement.session = SessionId(name);
    placement.component = component;
    for (const auto& [index, submap] : view.Find(SessionId(name))->submaps) {
      placement.submaps.push_back({index, Pose(Eigen::Vector3d(10.0 * index, y, 0))});
    }
    revision->placements.push_back(placement);
    view.revision = revision;
  }
  void Anchors(const std::string& name) {
    Anchor anchor;
    anchor.submap = {SessionId(name), 0};
    anchor.given_ns = 5;
    view.anchors.Set(anchor.submap, anchor);
  }
  void Promises(const SessionPair& pair) { ledger.ranked.push_back({pair, 1}); }
  void Allows(const std::string& name, size_t pairs) {
    ledger.allowed[SessionId(name)] = {{.pairs = pairs, .searched = pairs, .joined = pairs}, 3};
  }

  MapView view;
  MatchingLedger ledger;
  ScheduleOptions options{.find_loops = false, .count_revisits = false, .rematch_submaps = 1};
};

struct Row {
  std::string name;
  std::function<void(Site&)> arrange;
  std::string next;  // Empty: nothing.
  uint64_t waiting_pairs = 0;

  friend std::ostream& operator<<(std::ostream& out, const Row& row) { return out << row.name; }
};

class MatchingScheduleTest : public ::testing::TestWithParam<Row> {};

TEST_P(MatchingScheduleTest, TheNextJobIs) {
  Site site;
  GetParam().arrange(site);
  const NextJob next = ChooseNext(site.view, site.ledger, site.options);
  EXPECT_EQ(next.key ? ToText(*next.key) : "", GetParam().next);
  if (next.waiting_pairs) {
    EXPECT_EQ(*next.waiting_pairs, GetParam().waiting_pairs);
  }
}

std::string NameOf(const ::testing::TestParamInfo<Row>& row) { return row.param.name; }

void TwoOfTwo(Site& s) {
  s.Has("a-1", 2);
  s.Has("b-1", 2);
}
void TwoTried(Site& s) {
  TwoOfTwo(s);
  s.Tries(kAB);
}

const std::vector<Row> kFewSessions = {
    {"EmptyMap", [](Site&) {}, ""},
    {"NewPair", TwoOfTwo, "match a-1 b-1", 1},
    {"TriedAsItIs", TwoTried, ""},
    {"Grown",
     [](Site& s) {
       TwoTried(s);
       s.Has("b-1", 3);
     },
     "match a-1 b-1", 1},
    {"GrownByLessThanIsAskedFor",
     [](Site& s) {
       s.options.rematch_submaps = 2;
       TwoTried(s);
       s.Has("b-1", 3);
     },
     ""},
    {"TheLastSubmapsCountAlways",
     [](Site& s) {
       s.options.rematch_submaps = 2;
       TwoTried(s);
       s.Has("b-1", 3);
       s.Finish("a-1");
       s.Finish("b-1");
     },
     "match a-1 b-1", 1},
    {"LoopsMovedItsMap",
     [](Site& s) {
       s.options.rematch_submaps = 2;
       TwoTried(s);
       s.ledger.shapes[SessionId("a-1")] = 1;
     },
     "match a-1 b-1", 1},
    {"AnchorsOfOneSayNothing",
     [](Site& s) {
       TwoTried(s);
       s.Anchors("a-1");
     },
     ""},
    {"AnchorsOfBoth",
     [](Site& s) {
       TwoTried(s);
       s.Anchors("a-1");
       s.Anchors("b-1");
     },
     "match a-1 b-1", 1},
    {"OthersAreAtIt",
     [](Site& s) {
       TwoOfTwo(s);
       s.Posts(MatchKey{kAB});
     },
     ""},
    {"TooFewPoints",
     [](Site& s) {
       TwoOfTwo(s);
       s.Has("b-1", 2, kLeastMatchedPoints - 1);
     },
     ""},
    {"MostEvidenceFirst",
     [](Site& s) {
       TwoOfTwo(s);
       s.Has("c-1", 5);
     },
     "match a-1 c-1", 3},
    {"NoRoomOnTheBoard",
     [](Site& s) {
       TwoOfTwo(s);
       for (uint32_t k = 0; k < kMaxPostedJobs; ++k) s.Posts(LoopKey{{SessionId("z-1"), k}});
     },
     "", 1},
};
INSTANTIATE_TEST_SUITE_P(FewSessions, MatchingScheduleTest, ::testing::ValuesIn(kFewSessions),
                         NameOf);

const std::vector<Row> kBesidePairs = {
    {"LoopsFirst",
     [](Site& s) {
       s.options.find_loops = true;
       TwoOfTwo(s);
       s.Places("b-1", 0);
     },
     "loops b-1/0"},
    {"LoopsGoOn",
     [](Site& s) {
       s.options.find_loops = true;
       TwoOfTwo(s);
       s.Places("b-1", 0);
       s.ledger.looped[SessionId("b-1")] = 1;
     },
     "loops b-1/1"},
    {"OneSearchOfASessionAtATime",
     [](Site& s) {
       s.options.find_loops = true;
       TwoOfTwo(s);
       s.Places("b-1", 0);
       s.ledger.looped[SessionId("b-1")] = 1;
       s.Posts(LoopKey{{SessionId("b-1"), 0}});
     },
     "match a-1 b-1", 1},
    {"LoopsAreNotWanted",
     [](Site& s) {
       TwoOfTwo(s);
       s.Places("b-1", 0);
     },
     "match a-1 b-1", 1},
    {"ShapesBeforePairs",
     [](Site& s) {
       TwoOfTwo(s);
       s.ledger.outdated_shapes.insert(SessionId("b-1"));
     },
     "shape b-1"},
    {"RevisitsLast",
     [](Site& s) {
       s.options.count_revisits = true;
       TwoTried(s);
       s.Places("a-1", 0);
     },
     "revisits"},
    {"RevisitsOncePerRevision",
     [](Site& s) {
       s.options.count_revisits = true;
       TwoTried(s);
       s.ledger.counted_revision = s.view.revision->revision;
     },
     ""},
    {"RevisitsWaitForPlaces",
     [](Site& s) {
       s.options.count_revisits = true;
       TwoTried(s);
       s.view.graph_version = 1;
     },
     ""},
};
INSTANTIATE_TEST_SUITE_P(BesidePairs, MatchingScheduleTest, ::testing::ValuesIn(kBesidePairs),
                         NameOf);

const std::vector<Row> kManySessions = {
    {"NobodyIsDueAPartner", [](Site& s) { s.HasMany(); }, ""},
    {"CompareANewSession",
     [](Site& s) {
       s.HasMany();
       s.ledger.indexed.erase(SessionId("d-1"));
     },
     "index d-1"},
    {"NotOneOfTwoSubmaps",
     [](Site& s) {
       s.HasMany();
       s.Has("z-1", 2);
     },
     ""},
    {"ButAFinishedOneOfTwo",
     [](Site& s) {
       s.HasMany();
       s.Has("z-1", 2);
       s.Finish("z-1");
     },
     "index z-1"},
    {"CompareAgainOnceGrownByHalf",
     [](Site& s) {
       s.HasMany();
       s.Has("d-1", 5);
     },
     "index d-1"},
    {"PromisingPair",
     [](Site& s) {
       s.HasMany();
       s.Promises(kAC);
       s.Allows("c-1", 1);
     },
     "match a-1 c-1", 1},
    {"NotBeyondTheAllowance",
     [](Site& s) {
       s.HasMany();
       s.Promises(kAC);
       s.Allows("c-1", 0);
     },
     ""},
    {"NotTwice",
     [](Site& s) {
       s.HasMany();
       s.Promises(kAC);
       s.Allows("c-1", 9);
       s.Tries(kAC);
     },
     ""},
    {"APairAtHandFirst",
     [](Site& s) {
       s.HasMany();
       s.Promises(kAC);
       s.Promises({SessionId("d-1"), SessionId("e-1")});
       s.Allows("c-1", 1);
       s.Allows("d-1", 1);
       s.ledger.last_pair = SessionPair(SessionId("e-1"), SessionId("f-1"));
     },
     "match d-1 e-1", 1},
    {"WhatIsNotJoinedFirst",
     [](Site& s) {
       s.HasMany();
       s.Promises(kAB);
       s.Promises(kAC);
       s.Allows("a-1", 9);
       s.Places("a-1", 0);
       s.Places("b-1", 0);
       s.Places("c-1", 1);
     },
     "match a-1 c-1", 1},
    {"NeighboursInOneComponent",
     [](Site& s) {
       s.HasMany();
       s.Allows("a-1", 9);
       s.Places("a-1", 0);
       s.Places("b-1", 0, 200);
       s.Places("c-1", 0, 20);
     },
     "match a-1 c-1", 1},
    {"SegmentsOfOneSession",
     [](Site& s) {
       s.HasMany();
       s.Has("b-1.2", 2);
       s.Promises(kAC);
       s.Allows("a-1", 9);
     },
     "match b-1 b-1.2", 1},
    {"TheServerBeforeEndedAtIt",
     [](Site& s) {
       s.HasMany();
       s.ledger.unfinished = {kAC};
     },
     "match a-1 c-1", 1},
    {"AgainOnceOneHasGrownByAGoodPart",
     [](Site& s) {
       s.HasMany();
       s.Tries(kAC);
       s.Has("c-1", 4);
     },
     "match a-1 c-1", 1},
    {"NotAtEverySubmap",
     [](Site& s) {
       s.HasMany();
       s.Has("a-1", 40);
       s.Has("c-1", 40);
       s.ledger.indexed[SessionId("a-1")] = s.ledger.indexed[SessionId("c-1")] = 40;
       s.Tries(kAC);
       s.Has("c-1", 41);
     },
     ""},
};
INSTANTIATE_TEST_SUITE_P(ManySessions, MatchingScheduleTest, ::testing::ValuesIn(kManySessions),
                         NameOf);

TEST(TriggerOf, TheLastSubmapsAreSearchedOnce) {
  Site site;
  TwoOfTwo(site);
  EXPECT_FALSE(TriggerOf(site.view, site.ledger, kAB, site.options).last_submaps);
  site.Finish("a-1");
  site.Finish("b-1");
  EXPECT_TRUE(TriggerOf(site.view, site.ledger, kAB, site.options).last_submaps);
  site.Tries(kAB);
  EXPECT_FALSE(TriggerOf(site.view, site.ledger, kAB, site.options).last_submaps);
}

TEST(TriggerOf, OfManySessionsAPairGetsAFirstLook) {
  Site site;
  TwoOfTwo(site);
  EXPECT_FALSE(TriggerOf(site.view, site.ledger, kAB, site.options).first_look);
  site.HasMany();
  site.Has("b-1.2", 2);
  EXPECT_TRUE(TriggerOf(site.view, site.ledger, kAB, site.options).first_look);
  const SessionPair segments(SessionId("b-1"), SessionId("b-1.2"));
  EXPECT_FALSE(TriggerOf(site.view, site.ledger, segments, site.options).first_look);
}

TEST(MatchingLedger, AForgottenJobIsDueAgain) {
  Site site;
  TwoTried(site);
  site.ledger.Forget(MatchKey{kAB});
  const NextJob next = ChooseNext(site.view, site.ledger, site.options);
  ASSERT_TRUE(next.key.has_value());
  EXPECT_EQ(*next.key, JobKey(MatchKey{kAB}));
}

TEST(MatchingLedger, AForgottenSearchForLoopsIsOnlyTakenBackWhereNoneCameAfterIt) {
  MatchingLedger ledger;
  const SessionId a("a-1");
  ledger.looped[a] = 5;
  ledger.Forget(LoopKey{{a, 3}});
  EXPECT_EQ(ledger.looped[a], 5u);
  ledger.Forget(LoopKey{{a, 4}});
  EXPECT_EQ(ledger.looped[a], 4u);
}

TEST(MatchingLedger, SessionsThatAreGoneLeaveIt) {
  Site site;
  TwoTried(site);
  site.ledger.looped[SessionId("b-1")] = site.ledger.indexed[SessionId("b-1")] = 2;
  site.Allows("b-1", 1);
  site.view.sessions.Erase(SessionId("b-1"));
  site.ledger.ForgetGone(site.view);
  EXPECT_TRUE(site.ledger.attempts.empty());
  EXPECT_TRUE(site.ledger.looped.empty());
  EXPECT_TRUE(site.ledger.indexed.empty());
  EXPECT_TRUE(site.ledger.allowed.empty());
}

}  // namespace
}  // namespace isthmus::server
