#include "server/matching/pairs/joint_refinement.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "core/geometry/angles.h"
#include "server/matching/pairs/hypothesis.h"
#include "server/matching/pairs/matcher.h"
#include "tests/server/matching/scene.h"
#include "tests/server/matching/whole_maps.h"

namespace isthmus::matching {
namespace {

Pose T_world_first() { return Pose::FromXyzRpy(3, 3, 1, 0, 0, 0.4); }
Pose T_world_second() { return Pose::FromXyzRpy(27, 8, 1, 0, 0, -2.0); }
Pose T_a_b() { return T_world_first().Inverse() * T_world_second(); }

SessionMap SurveyA() {
  return Survey(MakeGallery(), {Way({{3, 3, 1}, {9, 4, 1}, {13, 6, 1}, {18, 8, 1}, {27, 8, 1}}, 25),
                                T_world_first(), 0.01, 1});
}

SessionMap SurveyB() {
  SessionMap map =
      Survey(MakeGallery(), {Way({{27, 8, 1}, {18, 8, 1}, {13, 6, 1}, {9, 4, 1}, {3, 3, 1}}, 25),
                             T_world_second(), 0.01, 2});
  map.session = SessionId("robot_b-0001");
  return map;
}

// The odometry strays by as much from each submap to the next; the submaps stay as they are.
SessionMap Drifted(const SessionMap& map, const Pose& T_per_submap) {
  SessionMap drifted;
  drifted.session = map.session;
  Pose stray;
  for (const auto& submap : map.submaps) {
    auto moved = std::make_shared<Submap>(*submap);
    moved->T_odom_submap = submap->T_odom_submap * stray;
    stray = stray * T_per_submap;
    drifted.submaps.push_back(std::move(moved));
  }
  return drifted;
}

// The largest distance of b's submaps from their true places on a's.
double WorstError(const JointRefinement& joint, const SessionMap& a, const SessionMap& b) {
  double worst = 0;
  const Pose T_a = a.submaps.front()->T_odom_submap * joint.poses.a.front().Inverse();
  for (size_t k = 0; k < b.submaps.size(); ++k) {
    const Pose truth = T_a_b() * b.submaps[k]->T_odom_submap;
    worst = std::max(worst, (T_a * joint.poses.b[k].translation() - truth.translation()).norm());
  }
  return worst;
}

class JointRefinementTest : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    map_a_ = SurveyA();
    map_b_ = SurveyB();
  }
  static inline SessionMap map_a_, map_b_;
};

TEST_F(JointRefinementTest, PutsDriftedSubmapsWhereTheyBelong) {
  const SessionMap drifted =
      Drifted(map_b_, Pose::FromXyzRpy(0.08, -0.05, 0.01, 0, 0, 0.6 * kRadPerDeg));
  const PreparedMap a(map_a_), b(drifted);
  JointRefinement joint{MapPoses::Rigid(map_a_, drifted, T_a_b()), {}, 0, T_a_b()};
  EXPECT_GT(WorstError(joint, map_a_, map_b_), 0.3);
  ASSERT_TRUE(RefineJointly(a, b, 2.0, 0, 0, &joint));
  EXPECT_LT(WorstError(joint, map_a_, map_b_), 0.05);
  EXPECT_GT(joint.odometry_residual, 0.1);
  EXPECT_LT(joint.odometry_residual, 3);
  EXPECT_GE(joint.edges.size(), map_b_.submaps.size());
  for (const SubmapEdge& edge : joint.edges) {
    const Pose truth = map_a_.submaps[edge.submap_a]->T_odom_submap.Inverse() * T_a_b() *
                       map_b_.submaps[edge.submap_b]->T_odom_submap;
    EXPECT_LT((truth.Inverse() * edge.T_a_b).translation().norm(), 0.05);
    EXPECT_TRUE(edge.information.isApprox(edge.information.transpose()));
  }
}

TEST_F(JointRefinementTest, BendsNothingWhereTheOdometryIsRight) {
  const PreparedMap a(map_a_), b(map_b_);
  JointRefinement joint{MapPoses::Rigid(map_a_, map_b_, T_a_b()), {}, 0, T_a_b()};
  ASSERT_TRUE(RefineJointly(a, b, 2.0, 0, 0, &joint));
  EXPECT_LT(joint.odometry_residual, 0.2);
  EXPECT_LT((T_a_b().Inverse() * joint.T_a_b).translation().norm(), 0.02);
}

TEST_F(JointRefinementTest, MapsThatDoNotMeetAreLeftAlone) {
  const PreparedMap a(map_a_), b(map_b_);
  const Pose far = Pose(Eigen::Vector3d(500, 0, 0)) * T_a_b();
  JointRefinement joint{MapPoses::Rigid(map_a_, map_b_, far), {}, 0, far};
  EXPECT_FALSE(RefineJointly(a, b, 2.0, 0, 0, &joint));
  EXPECT_TRUE(joint.edges.empty());
  EXPECT_TRUE(joint.T_a_b.Matrix() == far.Matrix());
  const PreparedMap empty((SessionMap()));
  JointRefinement nothing{MapPoses::Rigid(map_a_, SessionMap(), far), {}, 0, far};
  EXPECT_FALSE(RefineJointly(a, empty, 2.0, 0, 0, &nothing));
}

// A map that is judged where it lies rigidly is contradicted by its own drift.
TEST_F(JointRefinementTest, DriftIsNoContradictionOnceItIsTakenOut) {
  const SessionMap drifted = Drifted(map_b_, Pose::FromXyzRpy(0.2, 0.1, 0, 0, 0, 1.2 * kRadPerDeg));
  const PreparedMap a(map_a_), b(drifted);
  const FreeSpaceScore rigid =
      ScoreFreeSpace(a.free_space(), b.free_space(), MapPoses::Rigid(map_a_, drifted, T_a_b()),
                     FreeSpaceOptions());
  Hypothesis h;
  h.T_a_b = T_a_b();
  MeasureJointly(a, b, &h);
  EXPECT_TRUE(h.converged);
  EXPECT_GT(rigid.violation(), 0.03);
  EXPECT_LT(h.free_space.violation(), 0.01);
}

TEST_F(JointRefinementTest, AMapThatGrowsIsExtendedNotSearchedAnew) {
  SessionMap grown = map_b_;
  grown.submaps.pop_back();
  const PreparedMap a(map_a_), before(grown), after(map_b_, before);
  EXPECT_EQ(after.submaps().front(), before.submaps().front());
  const MatcherOptions options = InTheGallery();
  PairMatcher matcher(options);
  const Match first = matcher.Update(a, before);
  ASSERT_EQ(first.state, MatchState::kAccepted) << first.detail;
  const Match second = matcher.Update(a, after);
  EXPECT_EQ(second.state, MatchState::kAccepted) << second.detail;
  EXPECT_EQ(second.stages.size(), 1u);
  EXPECT_EQ(second.stages.front().stage, "extend");
  EXPECT_GT(second.comparisons, first.comparisons);
  EXPECT_GT(second.edges.size(), first.edges.size());
  const Match scratch = MatchPrepared(a, PreparedMap(map_b_), options);
  EXPECT_LT((scratch.T_a_b.Inverse() * second.T_a_b).translation().norm(), 0.02);
  EXPECT_NEAR(scratch.overlap, second.overlap, 0.05);
  EXPECT_NEAR(static_cast<double>(scratch.comparisons), static_cast<double>(second.comparisons),
              0.1 * static_cast<double>(scratch.comparisons));
}

// Later submaps may contradict an accepted match.
TEST_F(JointRefinementTest, NewSubmapsCanContradict) {
  SessionMap wrong = map_b_;
  auto moved = std::make_shared<Submap>(*wrong.submaps.back());
  moved->T_odom_submap = moved->T_odom_submap * Pose::FromXyzRpy(4, 3, 0, 0, 0, 1.5);
  wrong.submaps.back() = moved;
  SessionMap grown = map_b_;
  grown.submaps.pop_back();
  const PreparedMap a(map_a_), before(grown), after(wrong, before);
  PairMatcher matcher(InTheGallery());
  const Match first = matcher.Update(a, before);
  ASSERT_EQ(first.state, MatchState::kAccepted) << first.detail;
  const Match second = matcher.Update(a, after);
  EXPECT_GT(second.free_space, 3 * first.free_space);
}

}  // namespace
}  // namespace isthmus::matching
