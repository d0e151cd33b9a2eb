#include "server/match_graph/cycles.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <random>
#include <string>

namespace isthmus::match_graph {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr double kDegree = 3.14159265358979323846 / 180;

// Robots in one building, whose true places are known: "a", "b", ... or "r00", "r01", ...
class CyclesTest : public ::testing::Test {
 protected:
  void MakeRobots(int count, uint32_t seed = 1) {
    std::mt19937 rng(seed);
    std::uniform_real_distribution<double> metres(-40, 40), radians(-3, 3);
    for (int i = 0; i < count; ++i) {
      char name[8];
      std::snprintf(name, sizeof(name), count > 26 ? "r%02d" : "%c", count > 26 ? i : 'a' + i);
      Node node{SessionId(name), 100.0 - i};
      node.center = Eigen::Vector3d(metres(rng) / 4, metres(rng) / 4, 0);
      node.extent_m = 30;
      nodes_.push_back(node);
      T_world_odom_.push_back(
          Pose::FromXyzRpy(metres(rng), metres(rng), 0.1, 0.02, -0.01, radians(rng)));
    }
  }

  // As it is in truth but for `error`, which acts in the middle of the second one's map.
  Match& Add(int a, int b, double confidence = 0.9, const Pose& error = Pose()) {
    Match match;
    match.a = nodes_[a].session;
    match.b = nodes_[b].session;
    const Pose T_b_middle(nodes_[b].center);
    match.T_a_b =
        T_world_odom_[a].Inverse() * T_world_odom_[b] * T_b_middle * error * T_b_middle.Inverse();
    match.state = MatchState::kAccepted;
    match.reason = MatchReason::kOk;
    match.confidence = confidence;
    matches_.push_back(match);
    return matches_.back();
  }

  void AddAll() {
    for (int a = 0; a < static_cast<int>(nodes_.size()); ++a) {
      for (int b = a + 1; b < static_cast<int>(nodes_.size()); ++b) Add(a, b);
    }
  }

  // "a-b" for every match that was set aside.
  std::vector<std::string> Check() {
    CheckCycles(nodes_, CycleOptions(), &matches_);
    std::vector<std::string> aside;
    for (const Match& match : matches_) {
      if (match.state == MatchState::kAccepted) continue;
      EXPECT_EQ(match.state, MatchState::kAmbiguous);
      EXPECT_EQ(match.reason, MatchReason::kCycle);
      aside.push_back(match.a.value() + "-" + match.b.value());
    }
    return aside;
  }

  Match& Of(const std::string& a, const std::string& b) {
    return *std::find_if(matches_.begin(), matches_.end(), [&](const Match& match) {
      return match.a.value() == a && match.b.value() == b;
    });
  }

  void Spoil(const std::string& a, const std::string& b, const Pose& error) {
    Match& match = Of(a, b);
    match.T_a_b = match.T_a_b * error;
  }

  std::vector<Node> nodes_;
  std::vector<Pose> T_world_odom_;
  std::vector<Match> matches_;
};

const Pose kTwinRoom(Eigen::Vector3d(12, 0, 0));

TEST_F(CyclesTest, TrueMatchesAgree) {
  MakeRobots(4);
  AddAll();
  EXPECT_THAT(Check(), IsEmpty());
  for (const Match& match : matches_) {
    EXPECT_NEAR(match.cycle_m, 0, 1e-6);
    EXPECT_NEAR(match.cycle_deg, 0, 1e-4);
  }
}

TEST_F(CyclesTest, AMatchInNoCycleHasNoResidual) {
  MakeRobots(4);
  Add(0, 1);
  Add(1, 2);
  Add(2, 3, 0.9, kTwinRoom);
  EXPECT_THAT(Check(), IsEmpty()) << "nothing contradicts the wrong one";
  for (const Match& match : matches_) {
    EXPECT_EQ(match.cycle_m, -1);
    EXPECT_EQ(match.cycle_deg, -1);
  }
}

TEST_F(CyclesTest, OneWrongMatchAmongFourRobotsIsFound) {
  for (const Pose& error :
       {kTwinRoom, Pose(Eigen::Vector3d(0, -5, 0)), Pose::FromXyzRpy(0, 0, 0, 0, 0, 3.14)}) {
    nodes_.clear(), T_world_odom_.clear(), matches_.clear();
    MakeRobots(4);
    AddAll();
    // Certain of itself though it is.
    Of("b", "c").confidence = 0.999;
    Spoil("b", "c", error);
    EXPECT_THAT(Check(), ElementsAre("b-c"));
    EXPECT_GT(std::max(Of("b", "c").cycle_m / 2, Of("b", "c").cycle_deg / 4), 1);
    EXPECT_NEAR(Of("a", "b").cycle_m, 0, 1e-6);
    EXPECT_EQ(Of("b", "c").confidence, 0.999) << "what was computed stays";
  }
}

TEST_F(CyclesTest, TheDetailNamesTheWayRoundAndTheNumbers) {
  MakeRobots(3);
  AddAll();
  Of("b", "c").confidence = 0.4;
  Of("b", "c").detail = "Overlap 40 %.";
  Spoil("b", "c", kTwinRoom);
  Check();
  EXPECT_THAT(Of("b", "c").detail, HasSubstr("Going round a, b, c, a leaves 12.00 m and 0.0 deg"));
  EXPECT_THAT(Of("b", "c").detail, HasSubstr("where 1.52 m and 3.0 deg are allowed"));
  EXPECT_THAT(Of("b", "c").detail, HasSubstr("Overlap 40 %."));
}

TEST_F(CyclesTest, TwoWrongMatchesApartAreBothFound) {
  MakeRobots(5);
  AddAll();
  Spoil("a", "b", kTwinRoom);
  Spoil("d", "e", Pose(Eigen::Vector3d(0, 9, 0)));
  EXPECT_THAT(Check(), ElementsAre("a-b", "d-e"));
}

// Every triangle of the four holds one of the two; only the square of the others agrees.
TEST_F(CyclesTest, TwoWrongMatchesThatTouchEveryTriangleAreBothFound) {
  MakeRobots(4);
  AddAll();
  Of("a", "b").confidence = Of("c", "d").confidence = 0.99;
  Spoil("a", "b", kTwinRoom);
  Spoil("c", "d", Pose(Eigen::Vector3d(0, 9, 0)));
  EXPECT_THAT(Check(), ElementsAre("a-b", "c-d"));
}

TEST_F(CyclesTest, ARobotWithTwoMatchesThatDisagreeLosesBoth) {
  MakeRobots(4);
  Add(0, 1);
  Add(0, 2);
  Add(1, 2);
  Add(0, 3);
  Add(1, 3, 0.9, kTwinRoom);
  EXPECT_THAT(Check(), ElementsAre("a-d", "b-d"));
}

TEST_F(CyclesTest, InALoneTriangleTheClearlyWeakestIsBlamed) {
  MakeRobots(3);
  Add(0, 1, 0.98);
  Add(1, 2, 0.97, kTwinRoom);
  Add(0, 2, 0.6);  // Odds 1.5 against 32.
  EXPECT_THAT(Check(), ElementsAre("a-c"));
  EXPECT_THAT(Of("a", "c").detail, HasSubstr("least certain"));
}

TEST_F(CyclesTest, InALoneTriangleWithoutAWeakestNothingIsBelieved) {
  MakeRobots(3);
  Add(0, 1, 0.9);
  Add(1, 2, 0.88, kTwinRoom);
  Add(0, 2, 0.8);
  EXPECT_THAT(Check(), ElementsAre("a-b", "b-c", "a-c"));
  EXPECT_THAT(Of("a", "c").detail, HasSubstr("nothing tells"));
}

TEST_F(CyclesTest, WhatWasGivenByHandIsTrue) {
  MakeRobots(3);
  Add(0, 1, 1, kTwinRoom).reason = MatchReason::kByHand;
  Add(1, 2, 0.999);
  Add(0, 2, 0.6);
  EXPECT_THAT(Check(), ElementsAre("a-c")) << "of the others the weakest";
  EXPECT_EQ(Of("a", "b").reason, MatchReason::kByHand);
}

TEST_F(CyclesTest, TheOnlyMatchOfACycleThatIsNotByHandGoes) {
  MakeRobots(4);
  AddAll();
  Of("a", "b").reason = MatchReason::kByHand;
  Of("b", "c").reason = MatchReason::kByHand;
  Spoil("a", "c", kTwinRoom);
  Of("a", "c").confidence = 1;
  EXPECT_THAT(Check(), ElementsAre("a-c"));
  EXPECT_THAT(Of("a", "c").detail, HasSubstr("by hand"));
}

TEST_F(CyclesTest, HandsThatDisagreeAreLeftAlone) {
  MakeRobots(3);
  Add(0, 1).reason = MatchReason::kByHand;
  Add(1, 2).reason = MatchReason::kByHand;
  Add(0, 2, 1, kTwinRoom).reason = MatchReason::kByHand;
  EXPECT_THAT(Check(), IsEmpty());
  EXPECT_NEAR(Of("a", "b").cycle_m, 12, 1e-6);
}

TEST_F(CyclesTest, ALongRingIsCheckedThroughTheForest) {
  MakeRobots(7);
  for (int i = 0; i < 7; ++i) Add(std::min(i, (i + 1) % 7), std::max(i, (i + 1) % 7), 0.95);
  EXPECT_THAT(Check(), IsEmpty());
  EXPECT_NEAR(Of("c", "d").cycle_m, 0, 1e-6);
  Spoil("c", "d", kTwinRoom);
  EXPECT_EQ(Check().size(), 7u);
}

// Each step is borne out by a triangle, and still the whole way round is off: drift.
TEST_F(CyclesTest, DriftThatAddsUpOnALongWayIsNoDisagreement) {
  MakeRobots(16);
  for (Pose& pose : T_world_odom_) pose = Pose(pose.translation());
  const Pose drift(Eigen::Vector3d(0.9, 0, 0));
  for (int i = 0; i < 8; ++i) {
    const int next = (i + 1) % 8;
    if (i < 7) Add(i, next, 0.9, drift);
    if (i == 7) Add(next, i, 0.9);
    Add(i, 8 + i);
    Add(next, 8 + i);
  }
  EXPECT_THAT(Check(), IsEmpty());
  EXPECT_NEAR(Of("c", "d").cycle_m, 0.9, 1e-6);
}

TEST_F(CyclesTest, DriftOfOdometryIsAllowedFor) {
  MakeRobots(4);
  for (Node& node : nodes_) node.extent_m = 200;
  AddAll();
  std::mt19937 rng(5);
  std::normal_distribution<double> metres(0, 0.6), radians(0, 0.5 * kDegree);
  for (Match& match : matches_) {
    match.T_a_b =
        match.T_a_b * Pose::FromXyzRpy(metres(rng), metres(rng), metres(rng), 0, 0, radians(rng));
  }
  EXPECT_THAT(Check(), IsEmpty());
}

// A small turn moves what is far away a lot; the maps lie where they lie.
TEST_F(CyclesTest, FarFromTheOriginOfOdomATurnCountsAsATurn) {
  MakeRobots(3);
  for (Node& node : nodes_) node.center = Eigen::Vector3d(400, 0, 0);
  for (Pose& pose : T_world_odom_) pose = Pose::FromXyzRpy(-400, 3, 0, 0, 0, 0);
  Add(0, 1, 0.9, Pose::FromXyzRpy(0, 0, 0, 0, 0, 2 * kDegree));
  Add(1, 2);
  Add(0, 2);
  EXPECT_THAT(Check(), IsEmpty());
  EXPECT_NEAR(Of("a", "b").cycle_deg, 2, 1e-6);
}

TEST_F(CyclesTest, WhatWasSetAsideComesBackWhenTheDisagreementGoes) {
  MakeRobots(3);
  AddAll();
  Spoil("b", "c", kTwinRoom);
  const std::vector<Match> computed = matches_;
  EXPECT_EQ(Check().size(), 3u);
  matches_ = computed;
  Of("b", "c").state = MatchState::kRejected;
  CheckCycles(nodes_, CycleOptions(), &matches_);
  EXPECT_EQ(Of("a", "b").state, MatchState::kAccepted);
  EXPECT_EQ(Of("a", "c").state, MatchState::kAccepted);
  EXPECT_EQ(Of("a", "c").cycle_m, -1);
}

TEST_F(CyclesTest, OrderOfInputDoesNotMatter) {
  MakeRobots(7);
  AddAll();
  Spoil("a", "b", kTwinRoom);
  Spoil("c", "g", Pose::FromXyzRpy(0, 0, 0, 0, 0, 1));
  Spoil("c", "f", kTwinRoom);
  std::mt19937 rng(3);
  const std::vector<Match> computed = matches_;
  std::vector<std::string> expected = Check();
  std::sort(expected.begin(), expected.end());
  EXPECT_THAT(expected, ElementsAre("a-b", "c-f", "c-g"));
  std::vector<Match> first = matches_;
  for (int round = 0; round < 20; ++round) {
    matches_ = computed;
    std::shuffle(nodes_.begin(), nodes_.end(), rng);
    std::shuffle(matches_.begin(), matches_.end(), rng);
    std::vector<std::string> actual = Check();
    std::sort(actual.begin(), actual.end());
    EXPECT_EQ(actual, expected);
    for (const Match& match : first) {
      const Match& same = Of(match.a.value(), match.b.value());
      EXPECT_EQ(same.cycle_m, match.cycle_m);
      EXPECT_EQ(same.detail, match.detail);
    }
  }
}

TEST_F(CyclesTest, MatchesOfStrangersAndUnusableOnesAreLeftAlone) {
  MakeRobots(3);
  AddAll();
  Match stranger = matches_.front();
  stranger.b = SessionId("ghost");
  Match nan = matches_.front();
  nan.confidence = std::nan("");
  matches_.push_back(stranger);
  matches_.push_back(nan);
  EXPECT_THAT(Check(), IsEmpty());
  EXPECT_EQ(matches_[3].cycle_m, -1);
  EXPECT_EQ(matches_[4].cycle_m, -1);
}

TEST_F(CyclesTest, ThirtyRobotsThatAllMeetAreCheckedInNoTime) {
  MakeRobots(30);
  AddAll();
  Spoil("r03", "r17", kTwinRoom);
  Spoil("r03", "r20", Pose::FromXyzRpy(0, 0, 0, 0, 0, 1));
  Spoil("r11", "r29", kTwinRoom);
  const std::clock_t begin = std::clock();
  EXPECT_THAT(Check(), ElementsAre("r03-r17", "r03-r20", "r11-r29"));
  const double seconds = static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
  RecordProperty("ms", std::to_string(1000 * seconds));
  EXPECT_LT(seconds, 1) << "of a budget of a few ms, on a machine that may be slow or watched";
}

// Beyond the limits of the search the forest still finds it.
TEST_F(CyclesTest, TooManyTrianglesLeaveTheForest) {
  MakeRobots(6);
  AddAll();
  for (Match& match : matches_) match.confidence = 0.999;
  Of("b", "f").confidence = 0.6;
  Spoil("b", "f", kTwinRoom);
  CycleOptions options;
  options.max_triangles = 4;
  CheckCycles(nodes_, options, &matches_);
  EXPECT_EQ(Of("b", "f").reason, MatchReason::kCycle);
  EXPECT_EQ(std::count_if(matches_.begin(), matches_.end(),
                          [](const Match& match) { return match.reason == MatchReason::kOk; }),
            14);
}

}  // namespace
}  // namespace isthmus::match_graph
