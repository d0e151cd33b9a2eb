#include "server/match_graph/groups.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <ctime>
#include <random>
#include <string>
#include <vector>

#include "server/match_graph/cycles.h"

namespace isthmus::match_graph {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::UnorderedElementsAre;

const Pose kTwinPlace(Eigen::Vector3d(12, 0, 0));

// Robots in one building, whose true places are known: "a", "b", ... Each has submaps 0, 1, 2, ...,
// 40 m apart.
class GroupsTest : public ::testing::Test {
 protected:
  void MakeRobots(int count) {
    std::mt19937 rng(1);
    std::uniform_real_distribution<double> metres(-40, 40), radians(-3, 3);
    for (int i = 0; i < count; ++i) {
      char name[8];
      std::snprintf(name, sizeof(name), count > 26 ? "r%02d" : "%c", count > 26 ? i : 'a' + i);
      Node node{SessionId(name), 100.0 - i};
      for (uint32_t k = 0; k < 5; ++k) node.submaps[k] = Eigen::Vector3d(40.0 * k, 0, 0);
      node.center = Eigen::Vector3d(80, 0, 0);
      node.extent_m = 160;
      nodes_.push_back(node);
      T_world_odom_.push_back(
          Pose::FromXyzRpy(metres(rng), metres(rng), 0.1, 0.02, -0.01, radians(rng)));
    }
  }

  // b's map lies off by `error`, as seen from it.
  Pose TransformOf(int a, int b, const Pose& error) const {
    const Pose T_b_middle(nodes_[b].center);
    return T_world_odom_[a].Inverse() * T_world_odom_[b] * T_b_middle * error *
           T_b_middle.Inverse();
  }

  Match& Accept(int a, int b, double confidence = 0.995, const Pose& error = Pose()) {
    Match& match = Open(a, b, confidence, 0, 0, error);
    match.state = MatchState::kAccepted;
    match.reason = MatchReason::kOk;
    return match;
  }

  // An open match that rests on these submaps.
  Match& Open(int a, int b, double confidence, uint32_t submap_a, uint32_t submap_b,
              const Pose& error = Pose()) {
    Match& match = matches_.emplace_back();
    match.a = nodes_[a].session;
    match.b = nodes_[b].session;
    match.T_a_b = TransformOf(a, b, error);
    match.state = MatchState::kAmbiguous;
    match.reason = MatchReason::kAmbiguous;
    match.detail = "Two are alike.";
    match.confidence = confidence;
    match.edges = {{submap_a, submap_b, {}, Matrix6d::Identity()}};
    return match;
  }

  RivalMatch Rival(int a, int b, double confidence, uint32_t submap_a, uint32_t submap_b,
                   const Pose& error = Pose()) const {
    RivalMatch rival;
    rival.T_a_b = TransformOf(a, b, error);
    rival.state = MatchState::kAmbiguous;
    rival.reason = MatchReason::kAmbiguous;
    rival.confidence = confidence;
    rival.free_space = 0.01;
    rival.edges = {{submap_a, submap_b, {}, Matrix6d::Identity()}};
    return rival;
  }

  static void Contradict(Match* match) {
    match->state = MatchState::kRejected;
    match->reason = MatchReason::kFreeSpace;
    match->edges.clear();
  }

  // "a-b" for every match that was settled.
  std::vector<std::string> Settle() {
    SettleGroups(nodes_, GroupOptions(), &matches_);
    std::vector<std::string> settled;
    for (const Match& match : matches_) {
      if (match.reason != MatchReason::kGroup) continue;
      EXPECT_EQ(match.state, MatchState::kAccepted);
      settled.push_back(match.a.value() + "-" + match.b.value());
    }
    return settled;
  }

  const Match& Of(const std::string& a, const std::string& b) const {
    return *std::find_if(matches_.begin(), matches_.end(), [&](const Match& match) {
      return match.a.value() == a && match.b.value() == b;
    });
  }

  std::vector<Node> nodes_;
  std::vector<Pose> T_world_odom_;
  std::vector<Match> matches_;
};

TEST_F(GroupsTest, ARobotIsJoinedByTwoOpenMatchesThatAgree) {
  MakeRobots(3);
  Accept(1, 2);
  Open(0, 1, 0.7, 0, 0);
  Match& small = Open(0, 2, 0.7, 2, 3);
  small.state = MatchState::kNotYet;
  small.reason = MatchReason::kTooSmall;
  EXPECT_THAT(Settle(), UnorderedElementsAre("a-b", "a-c"));
  EXPECT_THAT(Of("a", "b").detail, HasSubstr("Settled by way of c: going round leaves 0.00 m"));
  EXPECT_THAT(Of("a", "b").detail, HasSubstr("By itself it was AMBIGUOUS AMBIGUOUS: Two are ali"));
  EXPECT_GT(Of("a", "b").confidence, 0.99);
  EXPECT_NEAR(Of("a", "b").cycle_m, 0, 1e-6);
  EXPECT_EQ(Of("b", "c").reason, MatchReason::kOk);
}

TEST_F(GroupsTest, DriftWithinWhatCyclesLeaveOpenIsAgreement) {
  MakeRobots(3);
  Accept(1, 2);
  Open(0, 1, 0.8, 0, 0, Pose::FromXyzRpy(0.4, -0.3, 0, 0, 0, 0.01));
  Open(0, 2, 0.8, 2, 3);
  EXPECT_THAT(Settle(), UnorderedElementsAre("a-b", "a-c"));
  EXPECT_GT(Of("a", "b").cycle_m, 0.3);
}

TEST_F(GroupsTest, MatchesOnTheSameGroundAreOneWitness) {
  MakeRobots(3);
  Accept(1, 2);
  Open(0, 1, 0.9, 0, 0);  // a's submap 0 is the room that has a twin ...
  Open(0, 2, 0.9, 0, 3);  // ... into which both put it.
  EXPECT_THAT(Settle(), IsEmpty());
}

TEST_F(GroupsTest, MatchesThatDisagreeSettleNothing) {
  MakeRobots(3);
  Accept(1, 2);
  Open(0, 1, 0.9, 0, 0);
  Open(0, 2, 0.9, 2, 3, kTwinPlace);
  EXPECT_THAT(Settle(), IsEmpty());
}

TEST_F(GroupsTest, OneMatchAloneSettlesNothing) {
  MakeRobots(3);
  Accept(1, 2);
  Open(0, 1, 0.999, 0, 0);
  EXPECT_THAT(Settle(), IsEmpty());
}

TEST_F(GroupsTest, TheSecondBestIsTakenWhereTheOthersSayIt) {
  MakeRobots(3);
  Accept(1, 2);
  Match& match = Open(0, 1, 0.6, 0, 0, kTwinPlace);
  const Pose best = match.T_a_b;
  match.free_space = 0.008;
  match.rivals = {Rival(0, 1, 0.5, 1, 1)};
  Open(0, 2, 0.9, 3, 3);
  EXPECT_THAT(Settle(), UnorderedElementsAre("a-b", "a-c"));
  const Match& settled = Of("a", "b");
  EXPECT_NEAR((settled.T_a_b.Inverse() * TransformOf(0, 1, {})).translation().norm(), 0, 1e-9);
  EXPECT_EQ(settled.edges.front().submap_a, 1u);
  EXPECT_EQ(settled.free_space, 0.01);
  EXPECT_EQ(settled.runner_up, 0.008);
  EXPECT_THAT(settled.detail, HasSubstr("the alignment that was number 2"));
  ASSERT_EQ(settled.rivals.size(), 1u);
  EXPECT_EQ(settled.rivals[0].T_a_b.translation(), best.translation());
  EXPECT_EQ(settled.rivals[0].edges.front().submap_a, 0u);
}

TEST_F(GroupsTest, TwoPlacesThatBothFitAreNotToldApart) {
  MakeRobots(3);
  Accept(1, 2);
  const Pose next_rack(Eigen::Vector3d(0, 4, 0));
  Open(0, 1, 0.6, 0, 0).rivals = {Rival(0, 1, 0.3, 0, 0, next_rack)};
  // Off by as much as seen from a.
  Match& other = Open(0, 2, 0.6, 2, 3);
  const Pose T_0_1 = TransformOf(0, 1, {}), T_0_1_off = TransformOf(0, 1, next_rack);
  RivalMatch rival = Rival(0, 2, 0.3, 2, 3);
  rival.T_a_b = T_0_1_off * T_0_1.Inverse() * other.T_a_b;
  other.rivals = {rival};
  EXPECT_THAT(Settle(), IsEmpty());
  for (Match& match : matches_) match.rivals.clear();
  for (Match& match : matches_) match.confidence = 0.8;
  matches_.front().confidence = 0.995;
  EXPECT_THAT(Settle(), UnorderedElementsAre("a-b", "a-c")) << "it was the rivals";
}

TEST_F(GroupsTest, WhatFreeSpaceContradictsIsNotJoinedOver) {
  MakeRobots(4);
  Accept(1, 2);
  Accept(2, 3);
  Open(0, 1, 0.9, 0, 0);
  Open(0, 2, 0.9, 2, 3);
  Match& third = Open(0, 3, 0.1, 4, 4);
  Contradict(&third);
  EXPECT_THAT(Settle(), IsEmpty());
  matches_.back().T_a_b = TransformOf(0, 3, kTwinPlace);
  EXPECT_THAT(Settle(), UnorderedElementsAre("a-b", "a-c")) << "it was contradicted elsewhere";
}

TEST_F(GroupsTest, AContradictedRivalIsNeverTaken) {
  MakeRobots(3);
  Accept(0, 1);
  Accept(1, 2);
  Match& match = Open(0, 2, 0.6, 0, 0, kTwinPlace);
  match.rivals = {Rival(0, 2, 0.9, 1, 1)};
  match.rivals[0].state = MatchState::kRejected;
  EXPECT_THAT(Settle(), IsEmpty());
}

TEST_F(GroupsTest, APersonsWordIsNotOverruled) {
  MakeRobots(3);
  Accept(1, 2);
  Open(0, 1, 0.9, 0, 0);
  Match& rejected = Open(0, 2, 0.9, 2, 3);
  rejected.state = MatchState::kRejected;
  rejected.reason = MatchReason::kByHand;
  rejected.rivals = {Rival(0, 2, 0.9, 2, 3)};
  EXPECT_THAT(Settle(), IsEmpty());
  EXPECT_EQ(Of("a", "c").reason, MatchReason::kByHand);
}

TEST_F(GroupsTest, ThreeOpenMatchesThatCloseAreSettledTogether) {
  MakeRobots(3);
  Open(0, 1, 0.85, 0, 0);
  Open(0, 2, 0.85, 2, 0);
  Open(1, 2, 0.85, 3, 3);
  EXPECT_THAT(Settle(), UnorderedElementsAre("a-b", "a-c", "b-c"));
}

TEST_F(GroupsTest, ThreeThatCloseOnOneGroundAreNot) {
  MakeRobots(3);
  Open(0, 1, 0.85, 0, 0);
  Open(0, 2, 0.85, 0, 0);
  Open(1, 2, 0.85, 3, 3);
  EXPECT_THAT(Settle(), IsEmpty()) << "a may be in a twin of its place";
}

TEST_F(GroupsTest, ThreeThatCloseAndAreDoubtfulAreNot) {
  MakeRobots(3);
  Open(0, 1, 0.6, 0, 0);
  Open(0, 2, 0.6, 2, 0);
  Open(1, 2, 0.6, 3, 3);
  EXPECT_THAT(Settle(), IsEmpty());
}

TEST_F(GroupsTest, AnOpenMatchWithinAFrameIsSettledIfItAgrees) {
  MakeRobots(4);
  for (int i = 0; i < 3; ++i) Accept(i, i + 1);
  Open(0, 2, 0.2, 0, 0);
  Open(1, 3, 0.9, 0, 0, kTwinPlace);
  Match& slides = Open(0, 3, 0.9, 0, 0);
  slides.state = MatchState::kNotYet;
  slides.reason = MatchReason::kDegenerate;
  EXPECT_THAT(Settle(), ElementsAre("a-c"));
  EXPECT_EQ(Of("b", "d").state, MatchState::kAmbiguous);
  EXPECT_EQ(Of("a", "d").state, MatchState::kNotYet);
}

// A ring of frames works as one of sessions: a and b are merged, c and d are.
TEST_F(GroupsTest, FramesOfSeveralSessionsAreJoinedByChains) {
  MakeRobots(4);
  Accept(0, 1);
  Accept(2, 3);
  Open(0, 2, 0.7, 0, 4);
  EXPECT_THAT(Settle(), IsEmpty());
  Open(1, 3, 0.7, 4, 0);
  EXPECT_THAT(Settle(), UnorderedElementsAre("a-c", "b-d"));
  EXPECT_THAT(Of("a", "c").detail, HasSubstr("by way of b, d:"));
}

TEST_F(GroupsTest, TheOrderDoesNotMatter) {
  MakeRobots(8);
  std::mt19937 rng(5);
  std::uniform_real_distribution<double> confidence(0.7, 0.97);
  for (int a = 0; a < 8; ++a) {
    for (int b = a + 1; b < 8; ++b) {
      const bool right = rng() % 3 != 0;
      const Pose off(Eigen::Vector3d(5.0 * (rng() % 8) + 5, 0, 0));
      Match& match = Open(a, b, confidence(rng), rng() % 5, rng() % 5, right ? Pose() : off);
      match.rivals = {Rival(a, b, 0.1, rng() % 5, rng() % 5, right ? off : Pose())};
    }
  }
  const std::vector<Match> original = matches_;
  std::vector<std::string> first = Settle();
  EXPECT_GT(first.size(), 3u);
  std::sort(first.begin(), first.end());
  for (int round = 0; round < 10; ++round) {
    matches_ = original;
    std::shuffle(matches_.begin(), matches_.end(), rng);
    std::shuffle(nodes_.begin(), nodes_.end(), rng);
    std::vector<std::string> settled = Settle();
    std::sort(settled.begin(), settled.end());
    EXPECT_EQ(settled, first);
  }
}

TEST_F(GroupsTest, AHundredSessionsTakeLessThanASecond) {
  for (const double confidence : {0.5, 0.9}) {
    nodes_.clear(), T_world_odom_.clear(), matches_.clear();
    MakeRobots(100);
    std::mt19937 rng(6);
    std::uniform_real_distribution<double> metres(-60, 60), radians(-3, 3);
    for (int a = 0; a < 100; ++a) {
      for (int b = a + 1; b < 100; ++b) {
        const auto off = [&] {
          return Pose::FromXyzRpy(metres(rng), metres(rng), 0, 0, 0, radians(rng));
        };
        Match& match = Open(a, b, confidence, rng() % 5, rng() % 5, off());
        for (int i = 0; i < 3; ++i) {
          match.rivals.push_back(Rival(a, b, confidence, rng() % 5, rng() % 5, off()));
        }
      }
    }
    const std::clock_t begin = std::clock();
    Settle();
    const double seconds = static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
    EXPECT_LT(seconds, 1) << confidence;
    RecordProperty("seconds", std::to_string(seconds));
  }
}

// b and c, which are merged, put a into a twin of its room; d met it elsewhere.
class TwinRoomTest : public GroupsTest {
 protected:
  void MakeTwinRoom(double of_twin, double of_right) {
    MakeRobots(4);
    const Pose T_off = kTwinPlace;
    for (const int other : {1, 2}) {
      Match& match = Accept(0, other, of_twin);
      match.T_a_b = T_off * match.T_a_b;
      match.edges = {{0, 0, {}, Matrix6d::Identity()}};
    }
    Accept(0, 3, of_right).edges = {{3, 3, {}, Matrix6d::Identity()}};
    Accept(1, 2);
    Accept(1, 3).edges = {{4, 0, {}, Matrix6d::Identity()}};
    Accept(2, 3).edges = {{4, 2, {}, Matrix6d::Identity()}};
  }

  std::vector<std::string> Aside() {
    CheckCycles(nodes_, CycleOptions(), &matches_);
    std::vector<std::string> aside;
    for (const Match& match : matches_) {
      if (match.reason == MatchReason::kCycle) {
        aside.push_back(match.a.value() + "-" + match.b.value());
      }
    }
    EXPECT_THAT(Settle(), IsEmpty());
    return aside;
  }
};

TEST_F(TwinRoomTest, TwoThatAreWrongTogetherDoNotOutvoteOne) {
  MakeTwinRoom(0.99, 0.99);
  EXPECT_THAT(Aside(), UnorderedElementsAre("a-b", "a-c", "a-d"));
  EXPECT_THAT(Of("a", "d").detail, HasSubstr("rest on the same ground"));
}

TEST_F(TwinRoomTest, TheMoreCertainOneStays) {
  MakeTwinRoom(0.9, 0.995);
  EXPECT_THAT(Aside(), UnorderedElementsAre("a-b", "a-c"));
}

TEST_F(TwinRoomTest, OnDifferentGroundTheyDo) {
  MakeTwinRoom(0.99, 0.99);
  const_cast<Match&>(Of("a", "c")).edges[0].submap_a = 4;
  EXPECT_THAT(Aside(), ElementsAre("a-d"));
}

}  // namespace
}  // namespace isthmus::match_graph
