#include "server/matching/pairs/anchor_prior.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <vector>

#include "core/geometry/angles.h"
#include "server/matching/pairs/limits.h"
#include "tests/server/matching/scene.h"
#include "tests/server/matching/whole_maps.h"

namespace isthmus::matching {
namespace {

Pose T_site_world() { return Pose::FromXyzRpy(400, -70, 12, 0, 0, 2.5); }

class AnchorPriorTest : public ::testing::Test {
 protected:
  static Pose T_world_a() { return Pose::FromXyzRpy(3, 3, 1, 0.05, -0.04, 0.3); }
  static Pose T_world_b() { return Pose::FromXyzRpy(27, 8, 1, -0.06, 0.03, -2.0); }

  static void SetUpTestSuite() {
    const Scene scene = MakeGallery();
    map_a_ = Survey(
        scene, {Way({{3, 3, 1}, {10, 6, 1}, {14, 6, 1}, {20, 9, 1}}, 12), T_world_a(), 0.01, 1});
    map_b_ = Survey(
        scene, {Way({{27, 8, 1}, {18, 8, 1}, {13, 6, 1}, {9, 4, 1}}, 12), T_world_b(), 0.01, 2});
    a_ = std::make_unique<PreparedMap>(map_a_);
    b_ = std::make_unique<PreparedMap>(map_b_);
  }
  static void TearDownTestSuite() {
    a_.reset();
    b_.reset();
  }

  static Anchor At(const SessionMap& map, size_t submap, const Pose& T_world_odom, double sigma_xy,
                   double sigma_z, double sigma_deg) {
    Anchor anchor;
    anchor.submap = map.submaps[submap]->id;
    anchor.T_map_submap = T_site_world() * T_world_odom * map.submaps[submap]->T_odom_submap;
    anchor.sigma_xy_m = sigma_xy;
    anchor.sigma_z_m = sigma_z;
    anchor.sigma_deg = sigma_deg;
    return anchor;
  }
  static AnchorPrior Prior(const std::vector<Anchor>& anchors) { return {*a_, *b_, anchors}; }
  static Pose Truth() { return T_world_a().Inverse() * T_world_b(); }
  // With b moved in the world.
  static double LogOdds(const AnchorPrior& prior, const Pose& move = Pose()) {
    return prior.LogOdds(
        MapPoses::Rigid(map_a_, map_b_, T_world_a().Inverse() * move * T_world_b()));
  }

  static inline SessionMap map_a_, map_b_;
  static inline std::unique_ptr<PreparedMap> a_, b_;
};

TEST_F(AnchorPriorTest, OfOneMapAloneNothingFollows) {
  const AnchorPrior prior = Prior({At(map_a_, 0, T_world_a(), 0.5, 0.5, 2)});
  EXPECT_TRUE(prior.empty());
  EXPECT_EQ(LogOdds(prior), 0);
  EXPECT_FALSE(prior.Guess());
  EXPECT_EQ(LogOdds(AnchorPrior()), 0);
}

TEST_F(AnchorPriorTest, KnownStartsAreAGuessAndSpeakAgainstOtherPlaces) {
  const AnchorPrior prior =
      Prior({At(map_a_, 0, T_world_a(), 1, 0, 5), At(map_b_, 0, T_world_b(), 1, 0, 5)});
  ASSERT_TRUE(prior.Guess());
  const Pose error = Truth().Inverse() * *prior.Guess();
  EXPECT_LT(error.translation().norm(), 0.5);  // The sensors are at one height.
  EXPECT_LT(RotationAngle(error), 0.03);
  EXPECT_GT(LogOdds(prior), kMostByAnchors);
  EXPECT_LT(LogOdds(prior, Pose::FromXyzRpy(12, 0, 0, 0, 0, 0)), kRefutedByAnchors);
  EXPECT_LT(LogOdds(prior, Pose::FromXyzRpy(0, 0, 0, 0, 0, M_PI)), kRefutedByAnchors);
}

TEST_F(AnchorPriorTest, TwoPositionsSayWhichWayRound) {
  std::vector<Anchor> anchors;
  for (const size_t k : {size_t{0}, map_a_.submaps.size() - 1}) {
    anchors.push_back(At(map_a_, k, T_world_a(), 0.3, 0, 0));
  }
  for (const size_t k : {size_t{0}, map_b_.submaps.size() - 1}) {
    anchors.push_back(At(map_b_, k, T_world_b(), 0.3, 0, 0));
  }
  const AnchorPrior prior = Prior(anchors);
  ASSERT_TRUE(prior.Guess());
  EXPECT_LT((Truth().Inverse() * *prior.Guess()).translation().norm(), 0.5);
  // One each says how far apart they are, no more.
  const AnchorPrior ring = Prior({anchors[0], anchors[2]});
  EXPECT_FALSE(ring.Guess());
  const Eigen::Vector3d at = (T_world_a() * map_a_.submaps[0]->T_odom_submap).translation();
  const Pose turned = Pose(at) * Pose::FromXyzRpy(0, 0, 0, 0, 0, 2) * Pose(at).Inverse();
  EXPECT_NEAR(LogOdds(ring, turned), LogOdds(ring), 1e-6);
  EXPECT_LT(LogOdds(ring, Pose::FromXyzRpy(20, 0, 0, 0, 0, 0)), kRefutedByAnchors);
}

TEST_F(AnchorPriorTest, WhatIsVagueSaysNothing) {
  const AnchorPrior prior =
      Prior({At(map_a_, 0, T_world_a(), 1e6, 50, 0), At(map_b_, 0, T_world_b(), 1e6, 50, 0)});
  EXPECT_EQ(LogOdds(prior), 0);
  for (const double sigma :
       {1e-6, 0.1, 1.0, 10.0, 27.0, 100.0}) {  // True anchors never speak against the match.
    const double sigma_z = sigma / 10;
    EXPECT_GE(LogOdds(Prior({At(map_a_, 0, T_world_a(), sigma, sigma_z, 5),
                             At(map_b_, 0, T_world_b(), sigma, sigma_z, 5)})),
              0)
        << sigma;
  }
}

TEST_F(AnchorPriorTest, HeightsTellStoreys) {
  const AnchorPrior prior =
      Prior({At(map_a_, 0, T_world_a(), 0, 0.3, 0), At(map_b_, 0, T_world_b(), 0, 0.3, 0)});
  EXPECT_FALSE(prior.Guess());
  EXPECT_GT(LogOdds(prior), 1);
  EXPECT_LT(LogOdds(prior, Pose::FromXyzRpy(0, 0, 3, 0, 0, 0)), kRefutedByAnchors);
}

// By integrating over all places and headings of the site, numerically.
TEST_F(AnchorPriorTest, IsTheRatioOfEvidences) {
  const std::vector<Anchor> anchors = {
      At(map_a_, 0, T_world_a(), 5, 0, 0), At(map_a_, 2, T_world_a(), 4, 0, 30),
      At(map_b_, 0, T_world_b(), 6, 0, 0), At(map_b_, 2, T_world_b(), 5, 0, 0)};
  const auto evidence = [&](size_t first, size_t last, const Pose& T_world_odom_b) {
    constexpr double kStepM = 1, kStepRad = M_PI / 60;
    double sum = 0;
    for (double x = -50; x < 50; x += kStepM) {
      for (double y = -50; y < 50; y += kStepM) {
        for (double yaw = -M_PI; yaw < M_PI; yaw += kStepRad) {
          const Pose T = T_site_world() * Pose::FromXyzRpy(x, y, 0, 0, 0, yaw);
          double density = 1;
          for (size_t k = first; k < last; ++k) {
            const bool of_b = k >= 2;
            const SessionMap& map = of_b ? map_b_ : map_a_;
            const Pose T_world_odom = of_b ? T_world_odom_b : T_world_a();
            const Pose at = T * T_world_odom * map.submaps[2 * (k % 2)]->T_odom_submap;
            const double s = anchors[k].sigma_xy_m;
            const double apart =
                (at.translation() - anchors[k].T_map_submap.translation()).head<2>().norm();
            density *= std::exp(-0.5 * apart * apart / (s * s)) / (2 * M_PI * s * s);
            if (anchors[k].sigma_deg == 0) continue;
            const double kappa = std::pow(anchors[k].sigma_deg * kRadPerDeg, -2);
            density *= std::exp(kappa * std::cos(at.Yaw() - anchors[k].T_map_submap.Yaw())) /
                       (2 * M_PI * std::cyl_bessel_i(0.0, kappa));
          }
          sum += density * kStepM * kStepM * kStepRad;
        }
      }
    }
    return std::log(sum / (kSiteM * kSiteM * 2 * M_PI));
  };
  const AnchorPrior prior = Prior(anchors);
  const double alone = evidence(0, 2, T_world_b()) + evidence(2, 4, T_world_b());
  for (const double shift : {0.0, 12.0, 18.0}) {
    const Pose move = Pose::FromXyzRpy(shift, 3, 0, 0, 0, 0.3);
    EXPECT_NEAR(LogOdds(prior, move), evidence(0, 4, move * T_world_b()) - alone, 0.1);
  }
}

}  // namespace
}  // namespace isthmus::matching
