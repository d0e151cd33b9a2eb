#include "server/matching/pairs/matcher.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "core/geometry/angles.h"
#include "core/paper.h"
#include "server/matching/prepared/prepared_map.h"
#include "tests/server/matching/scene.h"
#include "tests/server/matching/whole_maps.h"

namespace isthmus::matching {
namespace {

Pose T_world_a() { return Pose::FromXyzRpy(3, 3, 1, 0.05, -0.04, 0.3); }
Pose T_world_b() { return Pose::FromXyzRpy(27, 8, 1, -0.06, 0.03, -2.0); }

class MatcherTest : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    const Scene scene = MakeGallery();
    map_a_ = Survey(scene, {Way({{3, 3, 1}, {10, 6, 1}, {14, 6, 1}, {20, 9, 1}, {26, 10, 1}}, 20),
                            T_world_a(), 0.01, 1});
    map_b_ = Survey(scene, {Way({{27, 8, 1}, {18, 8, 1}, {13, 6, 1}, {9, 4, 1}, {3, 9, 1}}, 20),
                            T_world_b(), 0.01, 2});
  }

  static inline SessionMap map_a_, map_b_;
};

TEST_F(MatcherTest, AcceptsTheRightMergeWithAllFigures) {
  const Match match = MatchSessions(map_a_, map_b_, InTheGallery());
  EXPECT_EQ(match.state, MatchState::kAccepted) << ToString(match.reason) << ": " << match.detail;
  EXPECT_EQ(match.reason, MatchReason::kOk);
  EXPECT_FALSE(match.detail.empty());
  const Pose error = (T_world_a().Inverse() * T_world_b()).Inverse() * match.T_a_b;
  EXPECT_LT(error.translation().norm(), 0.03);
  EXPECT_LT(RotationAngle(error), 0.2 * kRadPerDeg);
  EXPECT_EQ(match.a, map_a_.session);
  EXPECT_EQ(match.b, map_b_.session);
  EXPECT_EQ(match.matcher, GuessSource::kBirdsEye);
  EXPECT_GT(match.confidence, 0.5);
  EXPECT_LE(match.confidence, 1.0);
  EXPECT_GT(match.overlap, 0.4);
  EXPECT_GT(match.inliers, 1000);
  EXPECT_GT(match.inlier_ratio, 0.7);
  EXPECT_GT(match.observability, 0.05);
  EXPECT_GT(match.shared_area_m2, 200);
  EXPECT_GE(match.odometry_residual, 0);
  EXPECT_LT(match.odometry_residual, 1);
  EXPECT_GT(match.candidates, 0u);
  EXPECT_FALSE(match.edges.empty());
  EXPECT_GT(match.residual_m, 0);
  EXPECT_LT(match.residual_m, 0.1);
  EXPECT_LT(match.free_space, 0.01);
  EXPECT_GT(match.comparisons, 3000);
  EXPECT_EQ(match.submaps_a, map_a_.submaps.size());
  EXPECT_EQ(match.submaps_b, map_b_.submaps.size());
  std::vector<std::string> names;
  for (const StageTime& stage : match.stages) {
    names.push_back(stage.stage);
    EXPECT_GE(stage.ms, 0);
  }
  EXPECT_EQ(names,
            (std::vector<std::string>{"prepare", "birds_eye", "refine", "free_space", "structure",
                                      "refine", "free_space", "places", "refine", "free_space",
                                      "refine", "free_space", "joint"}));
}

TEST_F(MatcherTest, IsDeterministicAndTheSameWhenPrepared) {
  const PreparedMap a(map_a_), b(map_b_);
  const Match prepared = MatchPrepared(a, b, MatcherOptions());
  const Match again = MatchSessions(map_a_, map_b_, MatcherOptions());
  EXPECT_TRUE(prepared.T_a_b.Matrix() == again.T_a_b.Matrix());
  EXPECT_EQ(prepared.confidence, again.confidence);
  EXPECT_EQ(prepared.comparisons, again.comparisons);
}

TEST_F(MatcherTest, LimitsDecide) {
  const PreparedMap a(map_a_), b(map_b_);
  MatcherOptions options;
  options.search = SearchMode::kBirdsEye;
  options.twins = Twins::kExact;
  const auto reason = [&] { return MatchPrepared(a, b, options).reason; };
  EXPECT_EQ(reason(), MatchReason::kPossibleTwin);
  options = InTheGallery();
  options.search = SearchMode::kBirdsEye;
  options.min_observability = 0.5;
  EXPECT_EQ(reason(), MatchReason::kDegenerate);
}

// The gallery may have a twin. Anchors say that it is this one, or that it is not.
TEST_F(MatcherTest, AnchorsDecideWhereMapsCannot) {
  const PreparedMap a(map_a_), b(map_b_);
  MatcherOptions options;
  options.twins = Twins::kExact;
  PairMatcher matcher(options);
  ASSERT_EQ(matcher.Update(a, b).reason, MatchReason::kPossibleTwin);
  const auto anchors_at = [&](const Pose& move_b, double sigma_z) {
    std::vector<Anchor> anchors(2);
    anchors[0].submap = map_a_.submaps[0]->id;
    anchors[0].T_map_submap = T_world_a() * map_a_.submaps[0]->T_odom_submap;
    anchors[1].submap = map_b_.submaps[0]->id;
    anchors[1].T_map_submap = move_b * T_world_b() * map_b_.submaps[0]->T_odom_submap;
    for (Anchor& anchor : anchors) {
      anchor.sigma_xy_m = 1;
      anchor.sigma_z_m = sigma_z;
      anchor.sigma_deg = 5;
    }
    return anchors;
  };
  matcher.SetAnchors(anchors_at(Pose(), 0));
  EXPECT_EQ(matcher.Update(a, b).reason, MatchReason::kPossibleTwin) << "it may be another storey";
  matcher.SetAnchors(anchors_at(Pose(), 0.5));
  const Match near = matcher.Update(a, b);
  EXPECT_EQ(near.state, MatchState::kAccepted) << near.detail;
  EXPECT_EQ(near.stages.size(), 1u) << "nothing was searched anew";
  matcher.SetAnchors(anchors_at(Pose::FromXyzRpy(0, 0, 3.3, 0, 0, 0), 0.3));
  EXPECT_NE(matcher.Update(a, b).state, MatchState::kAccepted) << "the storey above";
  PairMatcher other{MatcherOptions()};
  other.SetAnchors(anchors_at(Pose(Eigen::Vector3d(60, 0, 0)), 0.5));
  const Match far = other.Update(a, b);
  EXPECT_NE(far.state, MatchState::kAccepted) << far.detail;
  EXPECT_LT(far.confidence, 0.1);
}

// The same map from a robot whose sensor hangs at a slant or upside down.
TEST_F(MatcherTest, FindsWhichWayIsUp) {
  for (const Eigen::Vector3d& roll_pitch : {Eigen::Vector3d(M_PI, 0.1, 0), {0.4, 0.9, 0}}) {
    const Pose T_turned_odom = Pose::FromXyzRpy(5, -3, 8, roll_pitch.x(), roll_pitch.y(), 1);
    SessionMap turned;
    turned.session = SessionId("turned-0001");
    for (const auto& submap : map_b_.submaps) {
      auto moved = std::make_shared<Submap>(*submap);
      moved->T_odom_submap = T_turned_odom * submap->T_odom_submap;
      turned.submaps.push_back(std::move(moved));
    }
    const PreparedMap prepared(turned);
    const Eigen::Vector3d up = prepared.T_level_odom().rotation() * T_turned_odom.rotation() *
                               T_world_b().rotation().inverse() * Eigen::Vector3d::UnitZ();
    EXPECT_GT(prepared.may_be_upside_down() ? std::abs(up.z()) : up.z(), 0.99);
    const Match match = MatchSessions(map_a_, turned, InTheGallery());
    EXPECT_EQ(match.state, MatchState::kAccepted) << ToString(match.reason) << ": " << match.detail;
    const Pose truth = T_world_a().Inverse() * T_world_b() * T_turned_odom.Inverse();
    EXPECT_LT((truth.Inverse() * match.T_a_b).translation().norm(), 0.1);
  }
}

// A robot in one of two equal rooms, the other robot in the other: everything agrees, furniture
// too.
TEST_F(MatcherTest, NeverMergesTwinRooms) {
  Scene room;
  for (const double x : {0.0, 60.0}) {
    room.boxes.push_back({{x + 5, 4, -0.1}, {5.2, 4.2, 0.1}});
    room.boxes.push_back({{x + 5, 4, 3.6}, {5.2, 4.2, 0.1}});
    room.boxes.push_back({{x - 0.1, 4, 1.75}, {0.1, 4.2, 1.75}});
    room.boxes.push_back({{x + 10.1, 4, 1.75}, {0.1, 4.2, 1.75}});
    room.boxes.push_back({{x + 5, -0.1, 1.75}, {5.2, 0.1, 1.75}});
    room.boxes.push_back({{x + 5, 8.1, 1.75}, {5.2, 0.1, 1.75}});
    room.boxes.push_back({{x + 3, 5, 0.8}, {0.8, 0.4, 0.8}, 0.5});
    room.boxes.push_back({{x + 7, 2, 0.6}, {0.4, 0.6, 0.6}, 0.2});
  }
  const SessionMap a = Survey(room, {Way({{2, 2, 1}, {8, 6, 1}}, 10), Pose(), 0.01, 1});
  const SessionMap b = Survey(
      room, {Way({{62, 6, 1}, {68, 5, 1}}, 10), Pose::FromXyzRpy(62, 6, 1, 0, 0, 1.0), 0.01, 2});
  MatcherOptions options;
  options.twins = Twins::kExact;
  const Match match = MatchSessions(a, b, options);
  EXPECT_NE(match.state, MatchState::kAccepted) << match.detail;
  EXPECT_LT(match.confidence, 0.5);
}

// Robots in different parts of the gallery that see nothing in common.
TEST_F(MatcherTest, DoesNotMergeWithoutOverlap) {
  Scene scene = MakeGallery();
  for (SceneBox& box : Scene(scene).boxes) {  // Another building, mirrored, 100 m on.
    box.center.x() = 130 - box.center.x();
    box.yaw = -box.yaw;
    scene.boxes.push_back(box);
  }
  const SessionMap a =
      Survey(scene, {Way({{3, 3, 1}, {10, 6, 1}, {14, 6, 1}, {20, 9, 1}}, 15), Pose(), 0.01, 1});
  const SessionMap b = Survey(scene, {Way({{103, 9, 1}, {116, 6, 1}, {127, 3, 1}}, 15),
                                      Pose::FromXyzRpy(103, 9, 1, 0, 0, 0.5), 0.01, 2});
  const Match match = MatchSessions(a, b, MatcherOptions());
  EXPECT_NE(match.state, MatchState::kAccepted) << match.detail;
}

// Submaps that add nothing are taken out of a session now and then.
TEST_F(MatcherTest, AFirstLookChangesNothingWhereMapsMeet) {
  MatcherOptions options = InTheGallery();
  const Match in_full = MatchSessions(map_a_, map_b_, options);
  options.first_look = true;
  const Match match = MatchSessions(map_a_, map_b_, options);
  EXPECT_EQ(match.state, MatchState::kAccepted) << match.detail;
  EXPECT_TRUE(match.T_a_b.Matrix() == in_full.T_a_b.Matrix());
  EXPECT_EQ(match.confidence, in_full.confidence);
  EXPECT_EQ(match.rivals.size(), in_full.rivals.size());
}

TEST_F(MatcherTest, AFirstLookEndsTheSearchWhereNothingMeets) {
  // One robot in rooms, the other among pillars.
  Scene pillars{{{{0, 0, -0.5}, {40, 40, 0.5}}}};
  for (int i = 0; i < 60; ++i) {
    const double angle = 2.4 * i, range = 3 * std::sqrt(i + 1.0);
    pillars.boxes.push_back(
        {{range * std::cos(angle), range * std::sin(angle), 1.5}, {0.25, 0.25, 1.5}});
  }
  const SessionMap other =
      Survey(pillars, {Way({{0, -1, 1}, {-4, 3, 1}, {2, 9, 1}}, 20), Pose(), 0.01, 2});
  MatcherOptions options;
  const uint32_t in_full = MatchSessions(map_a_, other, options).candidates;
  options.first_look = true;
  const Match match = MatchSessions(map_a_, other, options);
  EXPECT_EQ(match.state, MatchState::kNotYet);
  EXPECT_EQ(match.reason, MatchReason::kNoCandidate) << match.detail;
  EXPECT_LT(2 * match.candidates, in_full);
  // A suggestion is searched in full whatever it looks like.
  PairMatcher suggested(options);
  Match known;
  known.T_a_b = Pose();
  suggested.Suggest(known);
  const Match searched = suggested.Update(PreparedMap(map_a_), PreparedMap(other));
  EXPECT_GE(searched.candidates, in_full);
}

TEST_F(MatcherTest, RetiredSubmapsCostNoSearch) {
  PairMatcher matcher(InTheGallery());
  SessionMap a = map_a_, b = map_b_;
  const auto last = b.submaps.back();
  b.submaps.pop_back();
  PreparedMap before_a(a), before_b(b);
  ASSERT_EQ(matcher.Update(before_a, before_b).state, MatchState::kAccepted);
  a.submaps.erase(a.submaps.begin() + 1);
  b.submaps.erase(b.submaps.begin());
  b.submaps.push_back(last);
  const PreparedMap after_a(a, before_a), after_b(b, before_b);
  EXPECT_EQ(after_a.submaps()[1], before_a.submaps()[2]);
  const Match match = matcher.Update(after_a, after_b);
  EXPECT_EQ(match.state, MatchState::kAccepted) << ToString(match.reason) << ": " << match.detail;
  ASSERT_EQ(match.stages.size(), 1u);
  EXPECT_EQ(match.stages[0].stage, "extend");
  EXPECT_EQ(match.submaps_a, a.submaps.size());
  ASSERT_FALSE(match.edges.empty());
  const auto at = [](const SessionMap& map, uint32_t index) {
    const auto is_it = [&](const auto& submap) { return submap->id.index == index; };
    return std::find_if(map.submaps.begin(), map.submaps.end(), is_it);
  };
  for (const SubmapEdge& edge : match.edges) {
    const auto in_a = at(a, edge.submap_a), in_b = at(b, edge.submap_b);
    ASSERT_NE(in_a, a.submaps.end());
    ASSERT_NE(in_b, b.submaps.end());
    const Pose truth =
        (T_world_a() * (*in_a)->T_odom_submap).Inverse() * T_world_b() * (*in_b)->T_odom_submap;
    EXPECT_LT((truth.Inverse() * edge.T_a_b).translation().norm(), 0.05);
  }
}

// Even when everything that was aligned is gone: the others lie where these left them.
TEST_F(MatcherTest, WhatIsLeftIsAlignedAnew) {
  const PreparedMap a(map_a_), b(map_b_);
  PairMatcher matcher(InTheGallery());
  const Match first = matcher.Update(a, b);
  ASSERT_EQ(first.state, MatchState::kAccepted);
  SessionMap rest = map_a_;
  rest.submaps.erase(rest.submaps.begin(), rest.submaps.end() - 2);
  const Match second = matcher.Update(PreparedMap(rest, a), b);
  ASSERT_FALSE(second.edges.empty());
  for (const SubmapEdge& edge : second.edges) {
    EXPECT_GE(edge.submap_a, rest.submaps.front()->id.index);
  }
  EXPECT_LT((first.T_a_b.Inverse() * second.T_a_b).translation().norm(), 0.1);
}

TEST_F(MatcherTest, EmptyMapsAreNotYet) {
  SessionMap empty;
  empty.session = SessionId("a-empty");
  const Match match = MatchSessions(empty, map_b_, MatcherOptions());
  EXPECT_EQ(match.state, MatchState::kNotYet);
  EXPECT_EQ(match.reason, MatchReason::kNoCandidate);
  EXPECT_FALSE(match.detail.empty());
}

TEST_F(MatcherTest, ThePapersChainAloneNamesItself) {
  if (!kHasPaper) GTEST_SKIP() << "built without it";
  MatcherOptions options;
  options.search = SearchMode::kPaper;
  const Match match = MatchSessions(map_a_, map_b_, options);
  for (const StageTime& stage : match.stages) EXPECT_NE(stage.stage, "birds_eye");
  EXPECT_TRUE(match.matcher == GuessSource::kNone || match.matcher == GuessSource::kPaper);
}

}  // namespace
}  // namespace isthmus::matching
