#include "server/matching/registration/refine.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/geometry/angles.h"
#include "tests/server/matching/scene.h"
#include "tests/server/matching/whole_maps.h"

namespace isthmus::matching {
namespace {

constexpr double kToleranceM = 0.02;
constexpr double kToleranceRad = 0.1 * M_PI / 180;

// Two robots in one gallery, their start frames 10 m and 70 degrees apart. They share the middle.
class RefineTest : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    const Scene scene = MakeGallery();
    const Drive drive_a{Way({{3, 3, 1}, {10, 6, 1}, {14, 6, 1}, {20, 9, 1}}, 15), T_world_a(), 0.01,
                        1};
    const Drive drive_b{Way({{27, 8, 1}, {18, 8, 1}, {13, 6, 1}, {9, 4, 1}}, 15), T_world_b(), 0.01,
                        2};
    map_a_ = new SessionMap(Survey(scene, drive_a));
    map_b_ = new SessionMap(Survey(scene, drive_b));
    a_ = new RefinableMap(MakeRefinable(*map_a_, options_));
    b_ = new RefinableMap(MakeRefinable(*map_b_, options_));
  }
  static void TearDownTestSuite() {
    delete a_;
    delete b_;
    delete map_a_;
    delete map_b_;
  }

  static Pose T_world_a() { return Pose::FromXyzRpy(3, 3, 1, 0.02, -0.03, 0.3); }
  static Pose T_world_b() { return Pose::FromXyzRpy(27, 8, 1, -0.04, 0.01, -2.0); }
  static Pose T_a_b() { return T_world_a().Inverse() * T_world_b(); }

  // The guess is off by this motion of the world.
  static Pose Guess(const Pose& off) { return T_world_a().Inverse() * off * T_world_b(); }

  static void ExpectNear(const Pose& estimate, const Pose& truth) {
    const Pose error = truth.Inverse() * estimate;
    EXPECT_LT(error.translation().norm(), kToleranceM);
    EXPECT_LT(RotationAngle(error), kToleranceRad);
  }

  static inline const RefineOptions options_;
  static inline SessionMap *map_a_ = nullptr, *map_b_ = nullptr;
  static inline RefinableMap *a_ = nullptr, *b_ = nullptr;
};

TEST_F(RefineTest, StaysAtTheTruth) {
  const Refinement result = RefineAlignment(*a_, *b_, T_a_b(), options_);
  EXPECT_TRUE(result.converged);
  ExpectNear(result.T_a_b, T_a_b());
  EXPECT_GT(result.overlap, 0.5);
  EXPECT_LT(result.residual_m, 0.05);
  EXPECT_GT(result.inliers, 1000);
}

TEST_F(RefineTest, Forward) {
  const Pose guess = Guess(Pose::FromXyzRpy(1.0, -0.8, 0.2, 0.02, 0.02, 4 * kRadPerDeg));
  ExpectNear(RefineAlignment(*a_, *b_, guess, options_).T_a_b, T_a_b());
}

TEST_F(RefineTest, ComesWithinDecimetresInItsFirstHalf) {
  const Pose guess = Guess(Pose::FromXyzRpy(1.0, -0.8, 0.2, 0.02, 0.02, 4 * kRadPerDeg));
  const Pose error = T_a_b().Inverse() * AlignCoarsely(*a_, *b_, guess, options_);
  EXPECT_LT(error.translation().norm(), 0.2);
  EXPECT_LT(RotationAngle(error), 1 * kRadPerDeg);
}

TEST_F(RefineTest, Inverse) {
  const Pose guess = Guess(Pose::FromXyzRpy(1.0, -0.8, 0.2, 0.02, 0.02, 4 * kRadPerDeg)).Inverse();
  ExpectNear(RefineAlignment(*b_, *a_, guess, options_).T_a_b, T_a_b().Inverse());
}

TEST_F(RefineTest, ComesBackFromMetresAndDegreesOff) {
  // About the middle of the gallery, as a search over yaw and cells errs.
  const Pose T_world_middle(Eigen::Vector3d(14, 6, 1));
  for (int i = 0; i < 8; ++i) {
    const double angle = i * M_PI / 4;
    const double yaw = (i % 2 == 0 ? 5 : -5) * kRadPerDeg;
    const Pose off =
        T_world_middle *
        Pose::FromXyzRpy(2.2 * std::cos(angle), 2.2 * std::sin(angle), 0.3, 0.03, -0.03, yaw) *
        T_world_middle.Inverse();
    SCOPED_TRACE(i);
    ExpectNear(RefineAlignment(*a_, *b_, Guess(off), options_).T_a_b, T_a_b());
  }
}

TEST_F(RefineTest, FramesFarFromTheOrigin) {
  SessionMap shifted = *map_b_;
  const Pose T_far_odom = Pose::FromXyzRpy(900, -700, 20, 0, 0, 1.0);
  for (auto& submap : shifted.submaps) {
    Submap copy = *submap;
    copy.T_odom_submap = T_far_odom * copy.T_odom_submap;
    submap = std::make_shared<Submap>(std::move(copy));
  }
  const RefinableMap far = MakeRefinable(shifted, options_);
  const Pose truth = T_a_b() * T_far_odom.Inverse();
  const Pose guess =
      Guess(Pose::FromXyzRpy(0.8, 0.8, 0.1, 0, 0, 2 * kRadPerDeg)) * T_far_odom.Inverse();
  const Refinement result = RefineAlignment(*a_, far, guess, options_);
  // Judged where the maps lie, not at an origin a kilometre away.
  ExpectNear(result.T_a_b * T_far_odom, truth * T_far_odom);
}

TEST_F(RefineTest, NoisyRanges) {
  const Scene scene = MakeGallery();
  const RefinableMap noisy = MakeRefinable(
      Survey(scene,
             {Way({{27, 8, 1}, {18, 8, 1}, {13, 6, 1}, {9, 4, 1}}, 15), T_world_b(), 0.05, 7}),
      options_);
  const Pose guess = Guess(Pose::FromXyzRpy(-0.7, 0.5, 0, 0, 0, -3 * kRadPerDeg));
  ExpectNear(RefineAlignment(*a_, noisy, guess, options_).T_a_b, T_a_b());
}

TEST_F(RefineTest, LittleOverlap) {
  const Scene scene = MakeGallery();
  const RefinableMap west = MakeRefinable(
      Survey(scene, {Way({{3, 3, 1}, {9, 8, 1}}, 10), T_world_a(), 0.01, 3}), options_);
  const RefinableMap east = MakeRefinable(
      Survey(scene, {Way({{27, 8, 1}, {15, 7, 1}}, 10), T_world_b(), 0.01, 4}), options_);
  const Pose guess = Guess(Pose::FromXyzRpy(0.5, 0.5, 0.1, 0, 0, 2 * kRadPerDeg));
  const Refinement result = RefineAlignment(west, east, guess, options_);
  ExpectNear(result.T_a_b, T_a_b());
  EXPECT_LT(result.overlap, 0.5);
}

TEST_F(RefineTest, EqualInputGivesEqualOutput) {
  const RefinableMap a = MakeRefinable(*map_a_, options_);
  const RefinableMap b = MakeRefinable(*map_b_, options_);
  const Pose guess = Guess(Pose::FromXyzRpy(0.5, -0.5, 0, 0, 0, 0.03));
  const Refinement first = RefineAlignment(*a_, *b_, guess, options_);
  const Refinement second = RefineAlignment(a, b, guess, options_);
  EXPECT_EQ(first.T_a_b.Matrix(), second.T_a_b.Matrix());
  EXPECT_EQ(first.overlap, second.overlap);
  EXPECT_EQ(first.information, second.information);
}

TEST_F(RefineTest, OverlapIsOfTheSmallerMapWhicheverComesFirst) {
  const Refinement ab = RefineAlignment(*a_, *b_, T_a_b(), options_);
  const Refinement ba = RefineAlignment(*b_, *a_, T_a_b().Inverse(), options_);
  EXPECT_NEAR(ab.overlap, ba.overlap, 0.02);
  EXPECT_NEAR(ab.residual_m, ba.residual_m, 0.005);
}

TEST_F(RefineTest, AWrongPlaceOverlapsLess) {
  const Refinement right = RefineAlignment(*a_, *b_, T_a_b(), options_);
  const Refinement wrong =
      RefineAlignment(*a_, *b_, Guess(Pose::FromXyzRpy(60, 0, 0, 0, 0, 0)), options_);
  EXPECT_EQ(wrong.inliers, 0);
  EXPECT_EQ(wrong.overlap, 0);
  EXPECT_FALSE(wrong.converged);
  EXPECT_GT(right.overlap, wrong.overlap);
}

TEST_F(RefineTest, InformationKnowsWhereACorridorSlides) {
  Scene corridor;
  corridor.boxes = {{{0, 0, -0.25}, {100, 5, 0.25}},
                    {{0, 0, 4.25}, {100, 5, 0.25}},
                    {{0, 2.25, 2}, {100, 0.25, 2}},
                    {{0, -2.25, 2}, {100, 0.25, 2}}};
  const RefinableMap map = MakeRefinable(
      Survey(corridor, {Way({{-5, 0, 1}, {5, 0, 1}}, 10), Pose(Eigen::Vector3d(0, 0, 1)), 0.01, 5}),
      options_);
  const Matrix6d H = RefineAlignment(map, map, Pose(), options_).information;
  EXPECT_LT(H(0, 0), 0.01 * H(1, 1));
  EXPECT_LT(H(0, 0), 0.01 * H(2, 2));
  EXPECT_TRUE(H.isApprox(H.transpose()));
}

TEST_F(RefineTest, EmptyMapsAndBadGuessesGiveNoConvergence) {
  const RefinableMap empty = MakeRefinable(SessionMap{}, options_);
  SessionMap hollow;
  hollow.submaps.push_back(std::make_shared<Submap>());
  const RefinableMap no_points = MakeRefinable(hollow, options_);
  for (const auto& [a, b] :
       {std::pair{&empty, &empty}, {a_, &empty}, {&empty, b_}, {&no_points, b_}}) {
    const Refinement result = RefineAlignment(*a, *b, T_a_b(), options_);
    EXPECT_FALSE(result.converged);
    EXPECT_EQ(result.overlap, 0);
    EXPECT_EQ(result.inliers, 0);
  }
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(RefineAlignment(*a_, *b_, Pose(Eigen::Vector3d(nan, 0, 0)), options_).converged);
}

}  // namespace
}  // namespace isthmus::matching
