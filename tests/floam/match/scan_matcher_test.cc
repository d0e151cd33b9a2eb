#include "floam/match/scan_matcher.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "floam/scan/undistort.h"
#include "tests/floam/room.h"

namespace isthmus::floam {
namespace {

using testing::FurnishedRoom;
using testing::MakeScan;
using testing::Room;
using testing::Sensor;

constexpr double kToleranceM = 0.01;
constexpr double kToleranceRad = 0.002;

PosePrior Anywhere(const Pose& near) { return {near, Matrix6d::Identity()}; }

// A map of the furnished room from several places, and a scan within it.
class ScanMatcherTest : public ::testing::Test {
 protected:
  ScanMatcherTest()
      : surfaces_(ShapeKind::kPlane, LocalMapOptions()),
        edges_(ShapeKind::kLine, LocalMapOptions()) {
    for (int k = 0; k < 12; ++k) {
      const Pose T_world_sensor =
          Pose::FromXyzRpy(-5 + 0.9 * k, 2.5 - 0.2 * k, 0.02 * k, 0, 0, 0.3 * k);
      const Features features = FeaturesOf([&](double) { return T_world_sensor; }, room_, k);
      for (const TimedPoint& p : features.map_surfaces) {
        surfaces_.Insert(T_world_sensor * p.position.cast<double>());
      }
      for (const TimedPoint& p : features.edges) {
        edges_.Insert(T_world_sensor * p.position.cast<double>());
      }
    }
  }

  static Features FeaturesOf(const testing::Motion& motion, const Room& room, int index) {
    RingScan scan;
    EXPECT_TRUE(
        RingSorter()
            .Sort(MakeScan(room, motion, Sensor(), index), *FindSensorModel("vlp16"), 0.1, &scan)
            .ok());
    Features features;
    FeatureExtractor(FeatureOptions()).Extract(scan, &features);
    return features;
  }

  MatchResult Match(const Features& features, const ScanPose& guess,
                    const std::optional<TwistPrior>& prior = std::nullopt) {
    MatchOptions options;
    options.max_iterations = 30;
    return matcher_.Match(features, guess, Anywhere(guess.T_odom_sensor), prior, options,
                          &surfaces_, &edges_);
  }

  static void ExpectNear(const Pose& expected, const Pose& actual) {
    const Pose error = expected.Inverse() * actual;
    EXPECT_LT(error.translation().norm(), kToleranceM);
    EXPECT_LT(RotationAngle(error), kToleranceRad);
  }

  const Room room_ = FurnishedRoom();
  LocalMap surfaces_, edges_;
  ScanMatcher matcher_;
  const Pose T_truth_ = Pose::FromXyzRpy(-1.7, 1.4, 0.05, 0.01, -0.02, 0.8);
};

TEST_F(ScanMatcherTest, ConvergesFromGuessesOnAllSides) {
  const Features features = FeaturesOf([&](double) { return T_truth_; }, room_, 100);
  for (const double sign : {1.0, -1.0}) {
    for (int axis = 0; axis < 6; ++axis) {
      const Vector6d offset = sign * (axis < 3 ? 0.2 : 0.05) * Vector6d::Unit(axis);
      const MatchResult match = Match(features, {T_truth_ * Exp(offset), Vector6d::Zero(), 0});
      SCOPED_TRACE(::testing::Message() << "offset " << offset.transpose());
      ExpectNear(T_truth_, match.pose.T_odom_sensor);
      EXPECT_GT(match.agreement, 0.8);
      EXPECT_FALSE(match.degeneracy.any());
    }
  }
}

TEST_F(ScanMatcherTest, AnswersDoNotDependOnTheGuess) {
  const Features features = FeaturesOf([&](double) { return T_truth_; }, room_, 101);
  const Pose a = Match(features, {T_truth_, Vector6d::Zero(), 0}).pose.T_odom_sensor;
  const Pose b = Match(features, {T_truth_ * Exp(Vector6d::Constant(0.05)), Vector6d::Zero(), 0})
                     .pose.T_odom_sensor;
  EXPECT_LT(Log(a.Inverse() * b).norm(), 2e-3);
}

TEST_F(ScanMatcherTest, SurvivesManyWrongPoints) {
  Features features = FeaturesOf([&](double) { return T_truth_; }, room_, 102);
  std::mt19937 random(9);
  std::uniform_real_distribution<float> uniform(-4, 4);
  for (size_t i = 0; i < features.surfaces.size(); i += 3) {
    features.surfaces[i].position += Eigen::Vector3f(uniform(random), uniform(random), 0);
  }
  const Vector6d offset = Vector6d::Constant(0.03);
  ExpectNear(T_truth_,
             Match(features, {T_truth_ * Exp(offset), Vector6d::Zero(), 0}).pose.T_odom_sensor);
}

TEST_F(ScanMatcherTest, EstimatesTheMotionWithinTheScan) {
  const Vector6d twist = (Vector6d() << 1.4, 0.1, 0, 0, 0, 0.9).finished();
  const auto motion = [&](double time_s) { return T_truth_ * Exp((time_s - 0.05) * twist); };
  const Features features = FeaturesOf(motion, room_, 0);
  TwistPrior prior;
  prior.sigma.setConstant(1);  // Hardly any: the scan itself must tell.
  const MatchResult match = Match(features, {T_truth_, Vector6d::Zero(), -0.05}, prior);
  ExpectNear(T_truth_, match.pose.T_odom_sensor);
  EXPECT_LT((match.pose.twist - twist).head<3>().norm(), 0.2);
  EXPECT_LT((match.pose.twist - twist).tail<3>().norm(), 0.05);
  // And its END follows.
  const Pose error = motion(0.1).Inverse() * match.pose.At(0);
  EXPECT_LT(error.translation().norm(), 2 * kToleranceM);
}

TEST_F(ScanMatcherTest, CovarianceIsSymmetricPositiveAndSmall) {
  const Features features = FeaturesOf([&](double) { return T_truth_; }, room_, 103);
  const MatchResult match = Match(features, {T_truth_, Vector6d::Zero(), 0});
  const Matrix6d covariance = match.covariance.topLeftCorner<6, 6>();
  EXPECT_TRUE(covariance.isApprox(covariance.transpose(), 1e-9));
  EXPECT_GT(covariance.selfadjointView<Eigen::Lower>().ldlt().vectorD().minCoeff(), 0);
  EXPECT_LT(covariance.diagonal().maxCoeff(), 1e-4);
}

TEST_F(ScanMatcherTest, FindsNothingInAnEmptyMap) {
  LocalMap no_surfaces(ShapeKind::kPlane, LocalMapOptions());
  LocalMap no_edges(ShapeKind::kLine, LocalMapOptions());
  const Features features = FeaturesOf([&](double) { return T_truth_; }, room_, 104);
  const MatchResult match =
      matcher_.Match(features, {T_truth_, Vector6d::Zero(), 0}, Anywhere(T_truth_), std::nullopt,
                     MatchOptions(), &no_surfaces, &no_edges);
  EXPECT_EQ(match.used, 0);
  EXPECT_EQ(match.agreement, 0);
  ExpectNear(T_truth_, match.pose.T_odom_sensor);
}

// A tunnel without ends: nothing says how far along it the sensor is.
TEST(Degeneracy, ATunnelIsNotObservedAlongItsAxis) {
  Room tunnel;
  tunnel.walls = {{-1000, -2, -1.2}, {1000, 2, 2.5}};
  RingScan scan;
  SensorModel model = *FindSensorModel("vlp16");
  model.max_range_m = 40;
  LocalMap surfaces(ShapeKind::kPlane, LocalMapOptions());
  LocalMap edges(ShapeKind::kLine, LocalMapOptions());
  Features features;
  for (int k = 0; k < 8; ++k) {
    const Pose T(Eigen::Vector3d(0.7 * k, 0, 0));
    const auto still = [&](double) { return T; };
    ASSERT_TRUE(RingSorter().Sort(MakeScan(tunnel, still, Sensor(), k), model, 0.1, &scan).ok());
    FeatureExtractor(FeatureOptions()).Extract(scan, &features);
    for (const TimedPoint& p : features.map_surfaces)
      surfaces.Insert(T * p.position.cast<double>());
  }
  const Pose T_truth(Eigen::Vector3d(0.7 * 7, 0, 0));
  const Pose T_guess = T_truth * Pose::FromXyzRpy(0.3, 0.1, 0.05, 0, 0, 0.02);
  // As the motion may have gone on: 5 cm and 0.02 rad.
  PosePrior expected{T_guess, 0.05 * 0.05 * Matrix6d::Identity()};
  expected.covariance.bottomRightCorner<3, 3>() *= 0.16;
  const MatchResult match = ScanMatcher().Match(features, {T_guess, Vector6d::Zero(), 0}, expected,
                                                std::nullopt, MatchOptions(), &surfaces, &edges);
  ASSERT_EQ(match.degeneracy.translations.size(), 1u);
  EXPECT_GT(std::abs(match.degeneracy.translations[0].x()), 0.99);
  EXPECT_TRUE(match.degeneracy.rotations.empty());
  const Pose error = T_truth.Inverse() * match.pose.T_odom_sensor;
  EXPECT_NEAR(error.translation().x(), 0.3, 0.05);  // As it was guessed.
  EXPECT_NEAR(error.translation().y(), 0, 0.01);
  EXPECT_NEAR(error.translation().z(), 0, 0.01);
  EXPECT_LT(RotationAngle(error), 0.003);

  // The speed along it is not seen, either: it stays as the motion so far has it.
  TwistPrior prior;
  prior.T_odom_previous = T_guess * Pose(Eigen::Vector3d(-0.13, 0, 0));
  prior.since_previous_s = 0.1;
  prior.sigma.setConstant(0.05);  // As the odometry has it.
  const Vector6d twist = (Vector6d() << 1.3, 0, 0, 0, 0, 0).finished();
  const MatchResult moving = ScanMatcher().Match(features, {T_guess, twist, 0}, expected, prior,
                                                 MatchOptions(), &surfaces, &edges);
  EXPECT_NEAR(moving.pose.twist.x(), 1.3, 0.05);
}

}  // namespace
}  // namespace isthmus::floam
