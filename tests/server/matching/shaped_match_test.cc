// Maps that their loops have straightened, matched.
#include <gtest/gtest.h>

#include <memory>

#include "core/geometry/angles.h"
#include "server/matching/pairs/hypothesis.h"
#include "server/matching/pairs/matcher.h"
#include "server/matching/pairs/odom_transform.h"
#include "server/matching/prepared/shape_keeper.h"
#include "tests/server/matching/scene.h"

namespace isthmus::matching {
namespace {

// There and back again: the last submap shows what the first does.
class ShapedMatchTest : public testing::Test {
 protected:
  static Pose T_world_a() { return Pose::FromXyzRpy(3, 3, 1, 0, 0, 0.4); }
  static Pose T_world_b() { return Pose::FromXyzRpy(27, 8, 1, 0, 0, -2.0); }

  static void SetUpTestSuite() {
    a_ = Survey(MakeGallery(), {Way({{3, 3, 1}, {9, 4, 1}, {13, 6, 1}, {18, 8, 1}, {27, 8, 1}}, 25),
                                T_world_a(), 0.01, 1});
    b_ = Survey(MakeGallery(), {Way({{27, 8, 1},
                                     {18, 8, 1},
                                     {13, 6, 1},
                                     {9, 4, 1},
                                     {3, 3, 1},
                                     {9, 4, 1},
                                     {13, 6, 1},
                                     {18, 8, 1},
                                     {27, 8, 1}},
                                    40),
                                T_world_b(), 0.01, 2});
    b_.session = SessionId("robot_b-0001");
  }

  // b with an odometry that strays by as much from each submap to the next.
  static SessionMap Drifted(const Pose& T_per_submap) {
    SessionMap drifted{b_.session, {}};
    Pose stray;
    for (const auto& submap : b_.submaps) {
      auto moved = std::make_shared<Submap>(*submap);
      moved->T_odom_submap = submap->T_odom_submap * stray;
      stray = stray * T_per_submap;
      drifted.submaps.push_back(std::move(moved));
    }
    return drifted;
  }

  // On the way back each submap lies on one of the way there.
  static std::vector<LoopClosure> Loops() {
    std::vector<LoopClosure> loops;
    const auto count = static_cast<uint32_t>(b_.submaps.size());
    for (uint32_t k = 0; 2 * k + 1 < count; ++k) {
      LoopClosure& loop = loops.emplace_back();
      loop.id = k + 1;
      loop.session = b_.session;
      const uint32_t j = count - 1 - k;
      loop.T_a_b = b_.submaps[k]->T_odom_submap.Inverse() * b_.submaps[j]->T_odom_submap;
      loop.edges = {{b_.submaps[k]->id.index, b_.submaps[j]->id.index, loop.T_a_b,
                     1e4 * Matrix6d::Identity()}};
    }
    return loops;
  }

  static PreparedMap Shaped(const SessionMap& drifted) {
    ShapeKeeper keeper;
    keeper.Update(drifted.submaps, Loops(), true, nullptr);
    return PreparedMap({drifted.session, keeper.submaps()}, PrepareSubmap, keeper.shape());
  }

  static double WorstEdge(const Match& match) {
    double worst = 0;
    for (const SubmapEdge& edge : match.edges) {
      const Pose truth = (T_world_a() * a_.submaps[edge.submap_a]->T_odom_submap).Inverse() *
                         T_world_b() * b_.submaps[edge.submap_b]->T_odom_submap;
      worst = std::max(worst, (truth.Inverse() * edge.T_a_b).translation().norm());
    }
    return worst;
  }

  static inline SessionMap a_, b_;
};

// A transform between odom frames stays one, whatever the shapes were: it lies as the edges want
// it.
TEST_F(ShapedMatchTest, TheTransformIsBetweenTheFramesOfTheOdometry) {
  const SessionMap drifted = Drifted(Pose::FromXyzRpy(0.12, 0.06, 0, 0, 0, 1.2 * kRadPerDeg));
  const PreparedMap a(a_), b = Shaped(drifted);
  PairMatcher matcher(InTheGallery());
  const Match match = matcher.Update(a, b);
  EXPECT_EQ(match.state, MatchState::kAccepted) << ToString(match.reason) << ": " << match.detail;
  EXPECT_LT(WorstEdge(match), 0.05);
  const FramePoses odometry = FramePoses::ByOdometry(a, b);
  ASSERT_TRUE(odometry.b[5].Matrix() == drifted.submaps[5]->T_odom_submap.Matrix());
  const std::optional<Pose> fit = FitRigid(odometry, match.edges, match.T_a_b);
  ASSERT_TRUE(fit.has_value());
  EXPECT_LT((fit->Inverse() * match.T_a_b).translation().norm(), 1e-6);
  // Between the shapes it is another, by decimetres.
  const std::optional<Pose> shapes =
      FitRigid(FramePoses::AsMatched(a.session_map(), b.session_map()), match.edges, match.T_a_b);
  ASSERT_TRUE(shapes.has_value());
  const Eigen::Vector3d middle = odometry.b[4].translation();
  EXPECT_GT((*shapes * middle - match.T_a_b * middle).norm(), 0.1);
}

// The bend that loops have made already is not held against a match.
TEST_F(ShapedMatchTest, AStrainIsWhatTheMatchAddsToIt) {
  const SessionMap drifted = Drifted(Pose::FromXyzRpy(0.12, 0.06, 0, 0, 0, 1.2 * kRadPerDeg));
  const PreparedMap a(a_), plain(drifted), shaped = Shaped(drifted);
  Hypothesis by_odometry, by_shape;
  by_odometry.T_a_b = by_shape.T_a_b = T_world_a().Inverse() * T_world_b();
  MeasureJointly(a, plain, &by_odometry);
  MeasureJointly(a, shaped, &by_shape);
  ASSERT_TRUE(by_shape.converged);
  EXPECT_LT(by_shape.odometry_residual, 1);
  EXPECT_GT(by_odometry.odometry_residual, 2 * by_shape.odometry_residual);
  EXPECT_LE(by_shape.free_space.violation(), by_odometry.free_space.violation());
}

// A submap that shows its place wrongly pulls the map as far as nothing else holds it.
TEST_F(ShapedMatchTest, LoopsHoldAgainstAWrongEdge) {
  SessionMap wrong = Drifted(Pose::FromXyzRpy(0.02, 0, 0, 0, 0, 0));
  auto torn = std::make_shared<Submap>(*b_.submaps.back());
  torn->T_odom_submap = wrong.submaps.back()->T_odom_submap;
  for (SubmapPoint& point : torn->points) point.x += 0.8f;
  for (Keyframe& keyframe : torn->keyframes) {
    keyframe.T_submap_sensor = Pose(Eigen::Vector3d(0.8, 0, 0)) * keyframe.T_submap_sensor;
  }
  wrong.submaps.back() = torn;
  const auto pulled = [&](const PreparedMap& b) {
    Hypothesis h;
    h.T_a_b = T_world_a().Inverse() * T_world_b();
    MeasureJointly(PreparedMap(a_), b, &h);
    const std::vector<Pose>& poses = h.joint.poses.b;
    const Pose T = poses[poses.size() - 2].Inverse() * poses.back();
    const Pose truth =
        b_.submaps[poses.size() - 2]->T_odom_submap.Inverse() * b_.submaps.back()->T_odom_submap;
    return (T.translation() - truth.translation()).norm();
  };
  EXPECT_LT(pulled(Shaped(wrong)), 0.5 * pulled(PreparedMap(wrong)));
}

TEST_F(ShapedMatchTest, WhatLoopsMoveIsJudgedAgainFromWhereItLay) {
  const SessionMap drifted = Drifted(Pose::FromXyzRpy(0.05, 0.03, 0, 0, 0, 0.5 * kRadPerDeg));
  const PreparedMap a(a_), plain(drifted), shaped = Shaped(drifted);
  PairMatcher matcher(InTheGallery());
  const Match first = matcher.Update(a, plain);
  ASSERT_EQ(first.state, MatchState::kAccepted) << first.detail;
  const Match second = matcher.Update(a, shaped);
  EXPECT_EQ(second.state, MatchState::kAccepted) << second.detail;
  ASSERT_EQ(second.stages.size(), 1u);
  EXPECT_EQ(second.stages[0].stage, "again");
  EXPECT_LT(WorstEdge(second), 0.05);
  EXPECT_LT((first.T_a_b.Inverse() * second.T_a_b).translation().norm(), 0.1);
}

// After a restart what was found is suggested to maps of another shape.
TEST_F(ShapedMatchTest, AKnownMatchIsTakenToTheShape) {
  const SessionMap drifted = Drifted(Pose::FromXyzRpy(0.05, 0.03, 0, 0, 0, 0.5 * kRadPerDeg));
  const PreparedMap a(a_), shaped = Shaped(drifted);
  PairMatcher matcher(InTheGallery());
  const Match first = matcher.Update(a, shaped);
  ASSERT_EQ(first.state, MatchState::kAccepted) << first.detail;
  PairMatcher restarted(InTheGallery());
  restarted.Suggest(first);
  const Match second = restarted.Update(a, shaped);
  EXPECT_EQ(second.state, MatchState::kAccepted);
  EXPECT_LT((first.T_a_b.Inverse() * second.T_a_b).translation().norm(), 0.03);
}

TEST_F(ShapedMatchTest, ReframeKeepsWhatNearSubmapsSay) {
  const SessionMap drifted = Drifted(Pose::FromXyzRpy(0.12, 0.06, 0, 0, 0, 1.2 * kRadPerDeg));
  const PreparedMap a(a_), b = Shaped(drifted);
  const FramePoses shapes = FramePoses::AsMatched(a.session_map(), b.session_map());
  const FramePoses odometry = FramePoses::ByOdometry(a, b);
  const Pose T_a_b = T_world_a().Inverse() * T_world_b();
  const Pose there = Reframe(shapes, odometry, {}, T_a_b);
  const Pose back = Reframe(odometry, shapes, {}, there);
  EXPECT_GT((there.translation() - T_a_b.translation()).norm(), 1e-3);
  EXPECT_LT((back.Inverse() * T_a_b).translation().norm(), 0.5);
  EXPECT_TRUE(Reframe(shapes, {}, {}, T_a_b).Matrix() == T_a_b.Matrix());
}

}  // namespace
}  // namespace isthmus::matching
