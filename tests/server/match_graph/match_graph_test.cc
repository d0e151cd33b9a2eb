#include "server/match_graph/match_graph.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <random>
#include <string>

#include "server/match_graph/cycles.h"

namespace isthmus::match_graph {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

SessionId Session(const std::string& name) { return SessionId(name); }

Node MakeNode(const std::string& name, double weight = 1) { return {Session(name), weight}; }

Match MakeMatch(const std::string& a, const std::string& b, double confidence,
                const Pose& T_a_b = Pose(), MatchState state = MatchState::kAccepted) {
  Match match;
  match.a = Session(a);
  match.b = Session(b);
  match.T_a_b = T_a_b;
  match.confidence = confidence;
  match.state = state;
  return match;
}

Pose RandomPose(std::mt19937* rng) {
  std::uniform_real_distribution<double> metres(-50, 50), radians(-3, 3);
  return Pose::FromXyzRpy(metres(*rng), metres(*rng), metres(*rng), radians(*rng),
                          radians(*rng) / 2, radians(*rng));
}

const Placement& Of(const Solution& solution, const std::string& name) {
  const auto it = std::find_if(solution.placements.begin(), solution.placements.end(),
                               [&](const Placement& p) { return p.session.value() == name; });
  EXPECT_NE(it, solution.placements.end()) << name;
  return *it;
}

void ExpectNear(const Pose& actual, const Pose& expected, double tolerance = 1e-9) {
  EXPECT_LT((actual.Matrix() - expected.Matrix()).cwiseAbs().maxCoeff(), tolerance);
}

TEST(MatchGraph, NothingGivesNothing) {
  const Solution solution = Solve({}, {}, {});
  EXPECT_THAT(solution.placements, IsEmpty());
  EXPECT_THAT(solution.tree, IsEmpty());
}

TEST(MatchGraph, LoneSessionIsItsOwnMap) {
  const Solution solution = Solve({MakeNode("b"), MakeNode("a")}, {}, {});
  ASSERT_EQ(solution.placements.size(), 2u);
  EXPECT_EQ(solution.placements[0].session, Session("a"));
  EXPECT_EQ(solution.placements[0].component, 0u);
  EXPECT_EQ(solution.placements[1].component, 1u);
  EXPECT_EQ(solution.placements[1].reference, Session("b"));
  ExpectNear(solution.placements[1].T_map_odom, Pose());
}

TEST(MatchGraph, ChainOfMatchesMultiplies) {
  std::mt19937 rng(1);
  const Pose T_a_b = RandomPose(&rng), T_b_c = RandomPose(&rng), T_c_d = RandomPose(&rng);
  const Solution solution = Solve({MakeNode("a", 9), MakeNode("b"), MakeNode("c"), MakeNode("d")},
                                  {MakeMatch("c", "d", .5, T_c_d), MakeMatch("a", "b", .6, T_a_b),
                                   MakeMatch("b", "c", .7, T_b_c)},
                                  {});
  ExpectNear(Of(solution, "a").T_map_odom, Pose());
  ExpectNear(Of(solution, "b").T_map_odom, T_a_b);
  ExpectNear(Of(solution, "c").T_map_odom, T_a_b * T_b_c);
  ExpectNear(Of(solution, "d").T_map_odom, T_a_b * T_b_c * T_c_d);
  EXPECT_THAT(solution.tree, ElementsAre(2, 1, 0));
}

TEST(MatchGraph, EdgeIsWalkedAgainstItsDirection) {
  std::mt19937 rng(2);
  const Pose T_a_b = RandomPose(&rng);
  const Solution solution =
      Solve({MakeNode("a"), MakeNode("b", 9)}, {MakeMatch("a", "b", .9, T_a_b)}, {});
  EXPECT_EQ(Of(solution, "a").reference, Session("b"));
  ExpectNear(Of(solution, "b").T_map_odom, Pose());
  ExpectNear(Of(solution, "a").T_map_odom, T_a_b.Inverse());
}

TEST(MatchGraph, OnlyAcceptedMatchesCarry) {
  for (const MatchState state :
       {MatchState::kRejected, MatchState::kAmbiguous, MatchState::kNotYet}) {
    const Solution solution =
        Solve({MakeNode("a"), MakeNode("b")}, {MakeMatch("a", "b", 1, Pose(), state)}, {});
    EXPECT_NE(Of(solution, "a").component, Of(solution, "b").component) << ToString(state);
    EXPECT_THAT(solution.tree, IsEmpty());
  }
}

// The fault of map_merge_3d: an edge that was rejected came back when it touched the largest
// component.
TEST(MatchGraph, RejectedMatchThatTouchesTheLargestComponentDoesNotCarry) {
  const Solution solution = Solve({MakeNode("a"), MakeNode("b"), MakeNode("c"), MakeNode("d")},
                                  {MakeMatch("a", "b", .9), MakeMatch("b", "c", .8),
                                   MakeMatch("c", "d", .99, Pose(), MatchState::kRejected),
                                   MakeMatch("a", "d", .99, Pose(), MatchState::kAmbiguous)},
                                  {});
  EXPECT_EQ(Of(solution, "c").component, 0u);
  EXPECT_EQ(Of(solution, "d").component, 1u);
  EXPECT_EQ(Of(solution, "d").reference, Session("d"));
  EXPECT_THAT(solution.tree, ElementsAre(0, 1));
}

TEST(MatchGraph, CycleDropsItsLeastConfidentMatch) {
  const Pose right(Eigen::Vector3d(1, 0, 0)), wrong(Eigen::Vector3d(70, 0, 0));
  const Solution solution = Solve({MakeNode("a", 9), MakeNode("b"), MakeNode("c")},
                                  {MakeMatch("a", "c", .2, wrong), MakeMatch("a", "b", .8, right),
                                   MakeMatch("b", "c", .7, right)},
                                  {});
  EXPECT_THAT(solution.tree, ElementsAre(1, 2));
  ExpectNear(Of(solution, "c").T_map_odom, Pose(Eigen::Vector3d(2, 0, 0)));
}

TEST(MatchGraph, UnusableMatchesAreLeftOut) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const Solution solution =
      Solve({MakeNode("a"), MakeNode("b")},
            {MakeMatch("a", "ghost", .9), MakeMatch("ghost", "b", .9), MakeMatch("a", "a", .9),
             MakeMatch("a", "b", nan), MakeMatch("a", "b", .9, Pose(Eigen::Vector3d(nan, 0, 0)))},
            {});
  ASSERT_EQ(solution.placements.size(), 2u);
  EXPECT_NE(Of(solution, "a").component, Of(solution, "b").component);
  EXPECT_THAT(solution.tree, IsEmpty());
}

TEST(MatchGraph, ComponentsAreNumberedBySizeThenReference) {
  const Solution solution = Solve(
      {MakeNode("a"), MakeNode("b"), MakeNode("c"), MakeNode("d"), MakeNode("e"), MakeNode("f")},
      {MakeMatch("d", "e", .9), MakeMatch("e", "f", .9)}, {});
  EXPECT_EQ(Of(solution, "d").component, 0u);
  EXPECT_EQ(Of(solution, "a").component, 1u);
  EXPECT_EQ(Of(solution, "b").component, 2u);
  EXPECT_EQ(Of(solution, "c").component, 3u);
}

TEST(MatchGraph, EqualComponentsKeepTheirOrder) {
  const std::vector<Node> bob_and_carol = {MakeNode("bob"), MakeNode("carol")};
  const Solution before = Solve(bob_and_carol, {}, {});
  std::vector<Node> nodes = bob_and_carol;
  nodes.push_back(MakeNode("alice", 1e6));
  const Solution beside = Solve(nodes, {}, before.placements);
  EXPECT_EQ(Of(beside, "bob").component, 0u);
  EXPECT_EQ(Of(beside, "carol").component, 1u);
  EXPECT_EQ(Of(beside, "alice").component, 2u);
  const Solution joined = Solve(nodes, {MakeMatch("alice", "carol", .9)}, beside.placements);
  EXPECT_EQ(Of(joined, "carol").component, 0u);
  const Solution apart = Solve(nodes, {}, joined.placements);
  EXPECT_LT(Of(apart, "carol").component, Of(apart, "bob").component);
}

TEST(MatchGraph, HeaviestBecomesTheReferenceAtFirst) {
  const Solution solution = Solve({MakeNode("a", 5), MakeNode("b", 7), MakeNode("c", 7)},
                                  {MakeMatch("a", "b", .9), MakeMatch("b", "c", .9)}, {});
  EXPECT_EQ(Of(solution, "a").reference, Session("b"));
}

TEST(MatchGraph, FrameStaysWhenAHeavierSessionJoins) {
  const std::vector<Match> first{MakeMatch("a", "b", .9)};
  const Solution before = Solve({MakeNode("a", 2), MakeNode("b", 1)}, first, {});
  ASSERT_EQ(Of(before, "b").reference, Session("a"));

  std::vector<Match> more = first;
  more.push_back(MakeMatch("b", "c", .95));
  const Solution after =
      Solve({MakeNode("a", 2), MakeNode("b", 10), MakeNode("c", 99)}, more, before.placements);
  for (const Placement& placement : after.placements) {
    EXPECT_EQ(placement.reference, Session("a"));
  }
}

TEST(MatchGraph, FrameStaysWhenTheTreeChanges) {
  const std::vector<Node> nodes{MakeNode("a", 3), MakeNode("b", 2), MakeNode("c", 1)};
  std::vector<Match> matches{MakeMatch("a", "b", .9), MakeMatch("b", "c", .8),
                             MakeMatch("a", "c", .1)};
  const Solution before = Solve(nodes, matches, {});
  matches[2].confidence = .95;
  const Solution after = Solve(nodes, matches, before.placements);
  EXPECT_NE(before.tree, after.tree);
  EXPECT_EQ(Of(after, "c").reference, Of(before, "c").reference);
}

TEST(MatchGraph, JoiningComponentsKeepTheReferenceOfTheLarger) {
  const std::vector<Node> nodes{MakeNode("a", 9), MakeNode("b", 1), MakeNode("c", 1),
                                MakeNode("x", 100), MakeNode("y", 50)};
  std::vector<Match> matches{MakeMatch("a", "b", .9), MakeMatch("b", "c", .9),
                             MakeMatch("x", "y", .9)};
  const Solution before = Solve(nodes, matches, {});
  ASSERT_EQ(Of(before, "y").reference, Session("x"));
  matches.push_back(MakeMatch("c", "x", .5));
  const Solution after = Solve(nodes, matches, before.placements);
  for (const Placement& placement : after.placements) {
    EXPECT_EQ(placement.reference, Session("a"));
    EXPECT_EQ(placement.component, 0u);
  }
}

TEST(MatchGraph, FrameStaysWhenAMatchIsSetAsideAndComesBack) {
  // d hangs on a and b, which disagree about it; the reference is neither.
  const std::vector<Node> nodes{MakeNode("a", 1), MakeNode("b", 2), MakeNode("c", 9),
                                MakeNode("d", 50)};
  const std::vector<Match> agreed{MakeMatch("a", "b", .9), MakeMatch("b", "c", .9),
                                  MakeMatch("a", "c", .9)};
  const Solution first = Solve(nodes, agreed, {});
  ASSERT_EQ(Of(first, "a").reference, Session("c"));

  std::vector<Match> disputed = agreed;
  disputed.push_back(MakeMatch("a", "d", .9));
  const Solution joined = Solve(nodes, disputed, first.placements);
  EXPECT_EQ(Of(joined, "d").reference, Session("c"));
  disputed.push_back(MakeMatch("b", "d", .9, Pose(Eigen::Vector3d(40, 0, 0))));
  CheckCycles(nodes, CycleOptions(), &disputed);
  ASSERT_EQ(disputed[3].reason, MatchReason::kCycle);
  ASSERT_EQ(disputed[4].reason, MatchReason::kCycle);
  const Solution apart = Solve(nodes, disputed, joined.placements);
  EXPECT_EQ(Of(apart, "d").reference, Session("d"));
  const Solution again =
      Solve(nodes, {agreed[0], agreed[1], agreed[2], MakeMatch("a", "d", .9)}, apart.placements);
  for (const Solution* solution : {&apart, &again}) {
    for (const char* name : {"a", "b", "c"}) {
      EXPECT_EQ(Of(*solution, name).reference, Session("c")) << name;
      EXPECT_EQ(Of(*solution, name).component, 0u);
      ExpectNear(Of(*solution, name).T_map_odom, Of(first, name).T_map_odom);
    }
  }
  EXPECT_EQ(Of(again, "d").reference, Session("c"));
}

TEST(MatchGraph, FrameStaysWhenItsOwnMatchIsSetAside) {
  const std::vector<Node> nodes{MakeNode("a", 9), MakeNode("b", 1), MakeNode("c", 2),
                                MakeNode("d", 3)};
  std::vector<Match> matches{MakeMatch("a", "b", .99), MakeMatch("a", "c", .9),
                             MakeMatch("a", "d", .9),  MakeMatch("b", "c", .9),
                             MakeMatch("b", "d", .9),  MakeMatch("c", "d", .9)};
  const Solution before = Solve(nodes, matches, {});
  matches[0].T_a_b = Pose(Eigen::Vector3d(30, 0, 0));
  CheckCycles(nodes, CycleOptions(), &matches);
  ASSERT_EQ(matches[0].reason, MatchReason::kCycle);
  const Solution after = Solve(nodes, matches, before.placements);
  EXPECT_NE(before.tree, after.tree);
  for (const Placement& placement : after.placements) {
    EXPECT_EQ(placement.reference, Session("a"));
    ExpectNear(placement.T_map_odom, Pose());
  }
}

TEST(MatchGraph, SplitGivesTheOrphansAReferenceOfTheirOwn) {
  const std::vector<Node> nodes{MakeNode("a", 9), MakeNode("b", 1), MakeNode("c", 2)};
  std::vector<Match> matches{MakeMatch("a", "b", .9), MakeMatch("b", "c", .9)};
  const Solution before = Solve(nodes, matches, {});
  matches[0].state = MatchState::kRejected;
  const Solution after = Solve(nodes, matches, before.placements);
  EXPECT_EQ(Of(after, "a").reference, Session("a"));
  EXPECT_EQ(Of(after, "b").reference, Session("c"));
  EXPECT_EQ(Of(after, "c").component, 0u);
}

TEST(MatchGraph, DeletedReferenceIsReplaced) {
  std::vector<Node> nodes{MakeNode("a", 9), MakeNode("b", 1), MakeNode("c", 2)};
  const std::vector<Match> matches{MakeMatch("a", "b", .9), MakeMatch("b", "c", .9)};
  const Solution before = Solve(nodes, matches, {});
  nodes.erase(nodes.begin());
  const Solution after = Solve(nodes, matches, before.placements);
  ASSERT_EQ(after.placements.size(), 2u);
  EXPECT_EQ(Of(after, "b").reference, Session("c"));
}

TEST(MatchGraph, OrderOfInputDoesNotMatter) {
  std::mt19937 rng(7);
  std::vector<Node> nodes;
  for (int i = 0; i < 12; ++i) nodes.push_back(MakeNode(std::string(1, char('a' + i)), i % 3));
  std::vector<Match> matches;
  for (size_t i = 0; i < nodes.size(); ++i) {
    for (size_t j = i + 1; j < nodes.size(); ++j) {
      // Few distinct confidences, so that ties decide.
      const double confidence = .25 * (1 + rng() % 3);
      const auto state = rng() % 6 ? MatchState::kRejected : MatchState::kAccepted;
      matches.push_back(MakeMatch(nodes[i].session.value(), nodes[j].session.value(), confidence,
                                  RandomPose(&rng), state));
    }
  }
  const Solution expected = Solve(nodes, matches, {});
  ASSERT_GT(expected.tree.size(), 4u);
  for (int round = 0; round < 20; ++round) {
    std::shuffle(nodes.begin(), nodes.end(), rng);
    std::shuffle(matches.begin(), matches.end(), rng);
    const Solution actual = Solve(nodes, matches, {});
    ASSERT_EQ(actual.placements.size(), expected.placements.size());
    for (size_t i = 0; i < actual.placements.size(); ++i) {
      EXPECT_EQ(actual.placements[i].session, expected.placements[i].session);
      EXPECT_EQ(actual.placements[i].component, expected.placements[i].component);
      EXPECT_EQ(actual.placements[i].reference, expected.placements[i].reference);
      EXPECT_EQ(actual.placements[i].T_map_odom.Matrix(),
                expected.placements[i].T_map_odom.Matrix());
    }
  }
}

TEST(FindTransform, BetweenTwoOfOneComponent) {
  std::mt19937 rng(3);
  const Pose T_a_b = RandomPose(&rng), T_a_c = RandomPose(&rng);
  const Solution solution =
      Solve({MakeNode("a", 9), MakeNode("b"), MakeNode("c"), MakeNode("lone")},
            {MakeMatch("a", "b", .6, T_a_b), MakeMatch("a", "c", .7, T_a_c)}, {});
  const auto T_b_c = FindTransform(solution.placements, Session("b"), Session("c"));
  ASSERT_TRUE(T_b_c.has_value());
  ExpectNear(*T_b_c, T_a_b.Inverse() * T_a_c);
  EXPECT_FALSE(FindTransform(solution.placements, Session("a"), Session("lone")).has_value());
  EXPECT_FALSE(FindTransform(solution.placements, Session("a"), Session("ghost")).has_value());
}

}  // namespace
}  // namespace isthmus::match_graph
