#include "server/matching/pairs/decision.h"

#include <gtest/gtest.h>

namespace isthmus::matching {
namespace {

Hypothesis Good() {
  Hypothesis h;
  h.source = GuessSource::kBirdsEye;
  h.converged = true;
  h.overlap = 0.4;
  h.inliers = 5000;
  h.residual_m = 0.03;
  h.free_space = {.agree = 99900, .front = 100};
  h.shared_area_m2 = 500;
  h.observability = 0.2;
  h.max_free_space = 0.02;
  return h;
}

Match DecideOn(std::vector<Hypothesis> hypotheses) {
  RankHypotheses(&hypotheses);
  Match match;
  DecideState(hypotheses, MatcherOptions(), &match);
  return match;
}

TEST(DecisionTest, AcceptsGoodEvidence) {
  const Match match = DecideOn({Good()});
  EXPECT_EQ(match.state, MatchState::kAccepted);
  EXPECT_EQ(match.reason, MatchReason::kOk);
  EXPECT_EQ(match.runner_up, -1);
  EXPECT_GT(match.confidence, 0.5);
}

TEST(DecisionTest, RivalsAreKeptWithWhatIsSaidOfThem) {
  Hypothesis second = Good(), contradicted = Good();
  second.T_a_b = Pose(Eigen::Vector3d(5, 0, 0));
  second.free_space = {.agree = 50000, .front = 50};
  second.source = GuessSource::kPlaces;
  second.joint.edges.resize(2);
  contradicted.free_space = {.agree = 40000, .front = 10000};
  contradicted.joint.edges.resize(3);
  const Match match = DecideOn({Good(), second, contradicted});
  ASSERT_EQ(match.rivals.size(), 2u);
  const RivalMatch& rival = match.rivals[0];
  EXPECT_EQ(rival.T_a_b.translation().x(), 5);
  EXPECT_EQ(rival.state, MatchState::kAmbiguous) << "good by itself, and not the best";
  EXPECT_EQ(rival.matcher, GuessSource::kPlaces);
  EXPECT_EQ(rival.comparisons, 50050);
  EXPECT_EQ(rival.edges.size(), 2u);
  EXPECT_GT(rival.confidence, 0.1);
  EXPECT_LT(rival.confidence, 0.5);
  EXPECT_EQ(match.rivals[1].state, MatchState::kRejected);
  EXPECT_TRUE(match.rivals[1].edges.empty());
  EXPECT_LT(match.rivals[1].confidence, 0.1);
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
  EXPECT_EQ(DecideOn({h}).state, MatchState::kAmbiguous);
  EXPECT_EQ(DecideOn({h}).reason, MatchReason::kPossibleTwin);
  h.shared_area_m2 = 5000;
  EXPECT_EQ(DecideOn({h}).reason, MatchReason::kOk);
  h.shared_area_m2 = 500;
  h.shared_share = 0.5;
  EXPECT_EQ(DecideOn({h}).reason, MatchReason::kOk);
}

TEST(DecisionTest, EachLackHasItsReason) {
  const auto with = [](auto change) {
    Hypothesis h = Good();
    change(h);
    return DecideOn({h});
  };
  Match match = with([](Hypothesis& h) { h.converged = false; });
  EXPECT_EQ(match.reason, MatchReason::kNotConverged);
  EXPECT_EQ(match.state, MatchState::kNotYet);
  match = with([](Hypothesis& h) { h.free_space = {.agree = 100, .front = 0}; });
  EXPECT_EQ(match.reason, MatchReason::kFewComparisons);
  EXPECT_EQ(match.state, MatchState::kNotYet);
  match = with([](Hypothesis& h) { h.odometry_residual = 5; });
  EXPECT_EQ(match.reason, MatchReason::kStrained);
  EXPECT_EQ(match.state, MatchState::kNotYet);
  match = with([](Hypothesis& h) { h.overlap = 0.05; });
  EXPECT_EQ(match.reason, MatchReason::kLowOverlap);
  EXPECT_EQ(match.state, MatchState::kNotYet);
  match = with([](Hypothesis& h) { h.free_space = {.agree = 90000, .front = 10000}; });
  EXPECT_EQ(match.reason, MatchReason::kFreeSpace);
  EXPECT_EQ(match.state, MatchState::kRejected);
  match = with([](Hypothesis& h) { h.shared_area_m2 = 100; });
  EXPECT_EQ(match.reason, MatchReason::kTooSmall);
  EXPECT_EQ(match.state, MatchState::kNotYet);
  match = with([](Hypothesis& h) { h.observability = 0.001; });
  EXPECT_EQ(match.reason, MatchReason::kDegenerate);
  EXPECT_EQ(match.state, MatchState::kNotYet);
}

TEST(DecisionTest, ATwinMakesItAmbiguous) {
  Hypothesis twin = Good();
  twin.free_space = {.agree = 80000, .front = 200};
  const Match match = DecideOn({twin, Good()});
  EXPECT_EQ(match.state, MatchState::kAmbiguous);
  EXPECT_EQ(match.reason, MatchReason::kAmbiguous);
  EXPECT_NEAR(match.free_space, 0.001, 1e-9);  // The better one is reported.
  EXPECT_NEAR(match.runner_up, 200.0 / 80200, 1e-9);
  EXPECT_LT(match.confidence, 0.5);
}

TEST(DecisionTest, AContradictedRivalDoesNotMatter) {
  Hypothesis rival = Good();
  rival.free_space = {.agree = 80000, .front = 1200};
  const Match match = DecideOn({rival, Good()});
  EXPECT_EQ(match.state, MatchState::kAccepted);
  EXPECT_NEAR(match.runner_up, 1200.0 / 81200, 1e-9);
}

// Containers were moved: the right place is contradicted, but fits more tightly than a wrong one
// that is not.
TEST(DecisionTest, ATighterRivalMakesItAmbiguous) {
  Hypothesis loose = Good(), tight = Good();
  loose.residual_m = 0.09;
  loose.inlier_ratio = 0.83;
  tight.residual_m = 0.037;
  tight.inlier_ratio = 0.8;
  tight.free_space = {.agree = 15000, .front = 4000};
  const Match match = DecideOn({loose, tight});
  EXPECT_EQ(match.state, MatchState::kAmbiguous);
  EXPECT_EQ(match.reason, MatchReason::kAmbiguous);
  EXPECT_EQ(match.residual_m, 0.09);
  EXPECT_NE(match.detail.find("37 mm"), std::string::npos) << match.detail;
  const auto accepted_beside = [&](auto change) {
    Hypothesis rival = tight;
    change(rival);
    return DecideOn({loose, rival}).state == MatchState::kAccepted;
  };
  EXPECT_TRUE(accepted_beside([](Hypothesis& h) { h.residual_m = 0.088; }));
  EXPECT_TRUE(accepted_beside([](Hypothesis& h) { h.inliers = 500; })) << "by chance";
  EXPECT_TRUE(accepted_beside([](Hypothesis& h) { h.inlier_ratio = 0.5; }));
  EXPECT_TRUE(accepted_beside([](Hypothesis& h) { h.converged = false; }));
  EXPECT_TRUE(accepted_beside([](Hypothesis& h) {
    h.free_space = {.agree = 4000, .front = 15000};
  })) << "no place of another day either";
}

// A score of zero out of next to nothing is no evidence, for or against.
TEST(DecisionTest, LittleEvidenceComesNeitherFirstNorSecond) {
  Hypothesis little = Good();
  little.overlap = 0.02;
  little.free_space = {.agree = 1000, .front = 0};
  const Match match = DecideOn({little, Good()});
  EXPECT_EQ(match.state, MatchState::kAccepted);
  EXPECT_EQ(match.comparisons, 100000);
  EXPECT_EQ(match.runner_up, -1);
}

TEST(DecisionTest, ConfidenceGrowsWithEvidence) {
  const double base = DecideOn({Good()}).confidence;
  Hypothesis h = Good();
  h.free_space = {.agree = 999000, .front = 1000};
  EXPECT_GT(DecideOn({h}).confidence, base);
  h = Good();
  h.free_space = {.agree = 99500, .front = 500};
  EXPECT_LT(DecideOn({h}).confidence, base);
  h = Good();
  h.shared_area_m2 = 1000;
  EXPECT_GT(DecideOn({h}).confidence, base);
  h = Good();
  h.converged = false;
  EXPECT_LT(DecideOn({h}).confidence, base);
  h = Good();
  h.shared_share = 0.97;
  EXPECT_LE(DecideOn({h}).confidence, 0.5) << "a twin is as likely";
  h = Good();
  h.free_space = {.agree = 96000, .front = 4000};
  EXPECT_LE(DecideOn({h}).confidence, 0.1) << "contradicted";
}

}  // namespace
}  // namespace isthmus::matching
