#include "server/matching/pairs/decision.h"

#include <gtest/gtest.h>

#include "server/matching/pairs/limits.h"
#include "server/matching/pairs/probability.h"

namespace isthmus::matching {
namespace {

// A hall seen by two robots, and well.
Hypothesis Good() {
  Hypothesis h;
  h.source = GuessSource::kBirdsEye;
  h.converged = true;
  h.overlap = 0.4;
  h.inliers = 5000;
  h.residual_m = 0.03;
  h.upright_ratio = 0.85;
  h.distinctive = 3000;
  h.things = {.there = 10, .gone = 1};
  h.own = {.near = 10000,
           .on = 9000,
           .squared_m2 = 9000 * 0.03 * 0.03,
           .near_upright = 5000,
           .on_upright = 4300};
  h.free_space = {.agree = 99900, .front = 100, .regions = 900, .contradicted_regions = 1};
  h.shared_area_m2 = 600;
  h.shared_share = 0.3;
  h.observability = 0.2;
  return h;
}

Match DecideOn(std::vector<Hypothesis> hypotheses, Twins twins = Twins::kRare) {
  RankByProbability(&hypotheses);
  Match match;
  MatcherOptions options;
  options.twins = twins;
  DecideState(hypotheses, options, &match);
  return match;
}

TEST(DecisionTest, AcceptsGoodEvidence) {
  const Match match = DecideOn({Good()});
  EXPECT_EQ(match.state, MatchState::kAccepted) << match.detail;
  EXPECT_EQ(match.reason, MatchReason::kOk);
  EXPECT_EQ(match.runner_up, -1);
  EXPECT_GE(match.confidence, MatcherOptions().min_probability);
}

TEST(DecisionTest, RivalsAreKeptWithWhatIsSaidOfThem) {
  Hypothesis second = Good(), contradicted = Good();
  second.T_a_b = Pose(Eigen::Vector3d(5, 0, 0));
  second.free_space = {.agree = 50100, .front = 50, .regions = 900, .contradicted_regions = 2};
  second.source = GuessSource::kPlaces;
  second.joint.edges.resize(2);
  contradicted.free_space = {
      .agree = 40000, .front = 40000, .regions = 900, .contradicted_regions = 400};
  contradicted.joint.edges.resize(3);
  const Match match = DecideOn({Good(), second, contradicted});
  EXPECT_EQ(match.reason, MatchReason::kAmbiguous);
  ASSERT_EQ(match.rivals.size(), 2u);
  const RivalMatch& rival = match.rivals[0];
  EXPECT_EQ(rival.T_a_b.translation().x(), 5);
  EXPECT_EQ(rival.state, MatchState::kAmbiguous) << "good by itself, and not the best";
  EXPECT_EQ(rival.matcher, GuessSource::kPlaces);
  EXPECT_EQ(rival.comparisons, 50150);
  EXPECT_EQ(rival.edges.size(), 2u);
  EXPECT_GT(rival.confidence, 0.1);
  EXPECT_LT(rival.confidence, 0.5);
  EXPECT_EQ(match.rivals[1].state, MatchState::kRejected);
  EXPECT_TRUE(match.rivals[1].edges.empty());
  EXPECT_LT(match.rivals[1].confidence, 0.05);
}

TEST(DecisionTest, NothingIsNotYet) {
  const Match match = DecideOn({});
  EXPECT_EQ(match.state, MatchState::kNotYet);
  EXPECT_EQ(match.reason, MatchReason::kNoCandidate);
  EXPECT_EQ(match.confidence, 0);
}

// Two closed halls built alike: all that both robots know agrees.
TEST(DecisionTest, WhereNeitherMapShowsMoreATwinWouldFitAsWell) {
  Hypothesis h = Good();
  h.shared_share = 0.97;
  EXPECT_EQ(DecideOn({h}).reason, MatchReason::kOk) << "such are rare";
  EXPECT_EQ(DecideOn({h}).detail.find("matching.twins"), std::string::npos);
  Hypothesis repeats = h;
  repeats.repetition = 0.2;
  EXPECT_NE(DecideOn({repeats}).detail.find("matching.twins"), std::string::npos)
      << DecideOn({repeats}).detail;
  for (const Twins twins : {Twins::kPossible, Twins::kExact}) {
    const Match match = DecideOn({h}, twins);
    EXPECT_EQ(match.state, MatchState::kAmbiguous);
    EXPECT_EQ(match.reason, MatchReason::kPossibleTwin);
    EXPECT_LE(match.confidence, 0.5) << "a twin is as likely";
  }
  h.shared_area_m2 = 5000;
  EXPECT_EQ(DecideOn({h}, Twins::kPossible).reason, MatchReason::kOk);
  EXPECT_EQ(DecideOn({h}, Twins::kExact).reason, MatchReason::kPossibleTwin);
  h.shared_area_m2 = 600;
  h.shared_share = 0.5;
  EXPECT_EQ(DecideOn({h}, Twins::kExact).reason, MatchReason::kOk);
}

TEST(DecisionTest, EachLackHasItsReason) {
  struct Case {
    const char* what;
    void (*change)(Hypothesis&);
    MatchState state;
    MatchReason reason;
  };
  const Case cases[] = {
      {"unsettled", [](Hypothesis& h) { h.converged = false; }, MatchState::kNotYet,
       MatchReason::kNotConverged},
      {"no views", [](Hypothesis& h) { h.can_be_refuted = false; }, MatchState::kNotYet,
       MatchReason::kFewComparisons},
      {"bent", [](Hypothesis& h) { h.odometry_residual = 5; }, MatchState::kNotYet,
       MatchReason::kStrained},
      {"sliding", [](Hypothesis& h) { h.observability = 0.0005; }, MatchState::kNotYet,
       MatchReason::kDegenerate},
      {"loose", [](Hypothesis& h) { h.residual_m = 0.12; }, MatchState::kNotYet,
       MatchReason::kLoose},
      {"half of the walls", [](Hypothesis& h) { h.upright_ratio = 0.2; }, MatchState::kNotYet,
       MatchReason::kLowOverlap},
      {"a bare chamber",
       [](Hypothesis& h) {
         h.shared_area_m2 = 20;
         h.things = {};
       },
       MatchState::kNotYet, MatchReason::kTooSmall},
      {"a bare room",
       [](Hypothesis& h) {
         h.shared_area_m2 = 40;
         h.things = {.there = 1, .gone = 0};
       },
       MatchState::kNotYet, MatchReason::kTooSmall},
      {"a room furnished otherwise",
       [](Hypothesis& h) {
         h.shared_area_m2 = 40;
         h.things = {.there = 4, .gone = 12};
       },
       MatchState::kNotYet, MatchReason::kFreeSpace},
      {"a chamber outdoors",
       [](Hypothesis& h) {
         h.outdoors = true;
         h.shared_area_m2 = 5;
       },
       MatchState::kNotYet, MatchReason::kTooSmall},
      {"rows of rooms",
       [](Hypothesis& h) {
         h.repetition = 0.8;
         h.distinctive = 5;
       },
       MatchState::kAmbiguous, MatchReason::kPossibleTwin},
      {"nothing upright", [](Hypothesis& h) { h.distinctive = 5; }, MatchState::kNotYet,
       MatchReason::kLowOverlap},
      {"looked through a little",
       [](Hypothesis& h) {
         h.free_space = {
             .agree = 80000, .front = 20000, .regions = 900, .contradicted_regions = 150};
       },
       MatchState::kNotYet, MatchReason::kFreeSpace},
      {"looked through",
       [](Hypothesis& h) {
         h.free_space = {
             .agree = 60000, .front = 40000, .regions = 900, .contradicted_regions = 400};
       },
       MatchState::kRejected, MatchReason::kFreeSpace},
  };
  for (const Case& one : cases) {
    Hypothesis h = Good();
    one.change(h);
    const Match match = DecideOn({h});
    EXPECT_EQ(match.state, one.state) << one.what << ": " << match.detail;
    EXPECT_EQ(match.reason, one.reason) << one.what << ": " << match.detail;
    EXPECT_FALSE(match.detail.empty());
  }
}

TEST(DecisionTest, ATwinMakesItAmbiguous) {
  Hypothesis twin = Good();
  twin.free_space = {.agree = 80000, .front = 90, .regions = 900, .contradicted_regions = 2};
  const Match match = DecideOn({twin, Good()});
  EXPECT_EQ(match.state, MatchState::kAmbiguous);
  EXPECT_EQ(match.reason, MatchReason::kAmbiguous);
  EXPECT_NEAR(match.free_space, 0.001, 1e-9);  // The better one is reported.
  EXPECT_NEAR(match.runner_up, 90.0 / 80090, 1e-9);
  EXPECT_LT(match.confidence, 0.7);
}

TEST(DecisionTest, AContradictedRivalDoesNotMatter) {
  Hypothesis rival = Good();
  rival.free_space = {.agree = 80000, .front = 30000, .regions = 900, .contradicted_regions = 200};
  EXPECT_EQ(DecideOn({rival, Good()}).state, MatchState::kAccepted);
}

// A fifth that is looked through is not outweighed by what agrees, though little of all is.
TEST(DecisionTest, ALargeHallDoesNotExcuseAWing) {
  Hypothesis h = Good();
  h.free_space = {.agree = 1000000, .front = 20000, .regions = 5000, .contradicted_regions = 1000};
  EXPECT_LT(h.free_space.violation(), 0.02);
  const Match match = DecideOn({h});
  EXPECT_NE(match.state, MatchState::kAccepted);
  EXPECT_EQ(match.reason, MatchReason::kFreeSpace);
}

TEST(ProbabilityTest, GrowsWithEvidence) {
  const double base = MeasureLogOdds(Good()).sum();
  const auto with = [](auto change) {
    Hypothesis h = Good();
    change(h);
    return MeasureLogOdds(h).sum();
  };
  EXPECT_GT(with([](Hypothesis& h) { h.residual_m = 0.02; }), base);
  EXPECT_GT(with([](Hypothesis& h) { h.shared_area_m2 = 1000; }), base);
  EXPECT_LT(with([](Hypothesis& h) { h.free_space.contradicted_regions = 10; }), base);
  EXPECT_LT(with([](Hypothesis& h) { h.free_space.front = 1000; }), base) << "things were moved";
  EXPECT_LT(with([](Hypothesis& h) { h.upright_ratio = 0.6; }), base);
  EXPECT_LT(with([](Hypothesis& h) { h.distinctive = 30; }), base) << "all of it repeats";
  EXPECT_GT(with([](Hypothesis& h) { h.things.there = 40; }), base);
  EXPECT_LT(with([](Hypothesis& h) { h.things.gone = 5; }), base);
  EXPECT_LT(with([](Hypothesis& h) { h.upside_down = true; }), base) << "a mirror image fits too";
  // Sensors that are noisy, or a world of leaves, make loose fits.
  EXPECT_GT(with([](Hypothesis& h) { h.own.squared_m2 *= 4; }), base);
}

// Two sessions of one submap each have nothing of their own to be compared with. No looseness is
// excused by what is not known.
TEST(ProbabilityTest, IsNoGreaterWhereNothingIsKnownOfEitherMapAlone) {
  Hypothesis unknown = Good();
  unknown.own = {};
  EXPECT_LT(MeasureLogOdds(unknown).sum(), MeasureLogOdds(Good()).sum());
  unknown.residual_m = 0.15;
  const Match match = DecideOn({unknown});
  EXPECT_EQ(match.reason, MatchReason::kLoose);
  EXPECT_NE(match.detail.find("is not known before it has two submaps"), std::string::npos)
      << match.detail;
}

TEST(HypothesisTest, WhatIsLookedThroughPromisesLess) {
  std::vector<Hypothesis> found(10, Good());
  for (size_t i = 0; i < found.size(); ++i) {
    found[i].inliers = 9000;
    found[i].free_space = {.agree = 8000, .front = 2000};
    found[i].T_a_b = Pose(Eigen::Vector3d(static_cast<double>(i), 0, 0));
  }
  found[7].inliers = 1000;
  found[7].free_space = {.agree = 2000, .front = 20};
  const std::vector<Hypothesis> best = MostPromising(&found);
  ASSERT_EQ(best.size(), kMaxJoint);
  EXPECT_EQ(best[0].T_a_b.translation().x(), 7);
  EXPECT_EQ(best[1].T_a_b.translation().x(), 0) << "those alike stay in order";
  EXPECT_EQ(found.size(), 10u);
}

TEST(ProbabilityTest, IsSharedAmongThoseThatCompete) {
  const double alone = Probabilities({Good()}).front();
  const std::vector<double> both = Probabilities({Good(), Good()});
  EXPECT_NEAR(both[0], both[1], 1e-12);
  EXPECT_LT(both[0] + both[1], 1);
  const double odds = alone / (1 - alone);
  EXPECT_NEAR(both[0], odds / (1 + 2 * odds), 1e-12);
}

// Maps made by one program may be exact, and still both know only a hall, which may have a twin, or
// racks that repeat. Anchors may know better.
TEST(DecisionTest, AnchorsTellWhatMapsCannot) {
  Hypothesis closed = Good();
  closed.shared_share = 0.97;
  EXPECT_EQ(DecideOn({closed}, Twins::kExact).reason, MatchReason::kPossibleTwin);
  closed.at_anchors = kMostByAnchors;
  EXPECT_EQ(DecideOn({closed}, Twins::kExact).state, MatchState::kAccepted);
  Hypothesis racks = Good();
  racks.distinctive = 5;
  racks.repetition = 0.3;
  EXPECT_EQ(DecideOn({racks}).reason, MatchReason::kPossibleTwin);
  racks.at_anchors = kMostByAnchors;  // The next rack is as near to them.
  EXPECT_EQ(DecideOn({racks}).reason, MatchReason::kPossibleTwin);
  racks.by_anchors = kMostByAnchors;
  EXPECT_EQ(DecideOn({racks}).state, MatchState::kAccepted);
  Hypothesis elsewhere = Good();
  elsewhere.at_anchors = elsewhere.by_anchors = -12;
  const Match match = DecideOn({elsewhere});
  EXPECT_EQ(match.state, MatchState::kAmbiguous);
  EXPECT_NE(match.detail.find("anchors"), std::string::npos) << match.detail;
}

// A flat of 40 square metres has what tells it from others.
TEST(DecisionTest, AFurnishedRoomIsEnough) {
  Hypothesis h = Good();
  h.shared_area_m2 = 40;
  h.distinctive = 10;
  h.things = {.there = 8, .gone = 1};
  EXPECT_EQ(DecideOn({h}).state, MatchState::kAccepted) << DecideOn({h}).detail;
}

TEST(DecisionTest, NothingMakesUpForNoGround) {
  Hypothesis h = Good();
  h.residual_m = 0;
  h.free_space = {.agree = 1000000, .front = 0, .regions = 9000, .contradicted_regions = 0};
  h.shared_area_m2 = 2;
  h.things = {.there = 1, .gone = 0};
  EXPECT_EQ(DecideOn({h}).reason, MatchReason::kTooSmall);
}

// Any measurement gives a probability.
TEST(ProbabilityTest, StaysAProbability) {
  Hypothesis nothing, everything = Good();
  everything.shared_area_m2 = 1e12;
  everything.own.squared_m2 = 1e12;
  for (const double p : Probabilities({nothing, everything})) {
    EXPECT_GE(p, 0);
    EXPECT_LE(p, 1);
  }
}

}  // namespace
}  // namespace isthmus::matching
