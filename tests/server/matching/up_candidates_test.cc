#include "server/matching/search/up_candidates.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/geometry/angles.h"
#include "core/pose.h"
#include "server/matching/search/wall_map.h"
#include "tests/server/matching/scene.h"
#include "tests/server/matching/whole_maps.h"

namespace isthmus::matching {
namespace {

// What is known of a map, in an odom frame that can be turned.
struct View {
  std::vector<SurfacePoint> surface;
  std::vector<Eigen::Vector3f> sensors;
  Eigen::Vector3d up;  // The truth.

  View Turned(const Eigen::Quaterniond& by) const {
    const Eigen::Matrix3f R = by.toRotationMatrix().cast<float>();
    View turned = *this;
    for (SurfacePoint& point : turned.surface) {
      point.position = R * point.position;
      point.normal = R * point.normal;
    }
    for (Eigen::Vector3f& sensor : turned.sensors) sensor = R * sensor;
    turned.up = by * up;
    return turned;
  }
};

View Look(const Scene& scene, const std::vector<Eigen::Vector3d>& way, double voxel_m) {
  const SessionMap map = Survey(scene, {way, Pose(), 0.01, 1});
  return {SampleSurface(map, voxel_m), SensorPositions(map), Eigen::Vector3d::UnitZ()};
}

// Even floor and even ceiling: the harder case of telling one from the other.
View LookAtGallery() {
  return Look(MakeGallery(), Way({{3, 3, 1}, {10, 6, 1}, {14, 6, 1}, {20, 9, 1}}, 15), 0.25);
}

// A yard between three houses, some crates, a slope at its end.
View LookAtYard() {
  Scene scene;
  scene.boxes = {{{0, 0, -0.5}, {60, 60, 0.5}},        {{-15, 10, 4}, {6, 4, 4}, 0.3},
                 {{14, 12, 3}, {5, 7, 3}, -0.2},       {{4, -16, 5}, {9, 4, 5}, 0.1},
                 {{-3, 3, 0.5}, {0.8, 0.6, 0.5}, 0.7}, {{8, -4, 0.7}, {2.0, 0.9, 0.7}, 1.2}};
  return Look(scene, Way({{-8, -3, 1.5}, {2, -6, 1.5}, {5, 4, 1.5}}, 15), 0.5);
}

std::vector<Eigen::Quaterniond> Turns() {
  const auto about = [](double degrees, const Eigen::Vector3d& axis) {
    return Eigen::Quaterniond(Eigen::AngleAxisd(degrees * kRadPerDeg, axis.normalized()));
  };
  return {Eigen::Quaterniond::Identity(), about(45, {1, 0, 0}),    about(90, {1, 0, 0}),
          about(90, {0, 1, 0}),           about(180, {1, 0, 0}),   about(180, {0, 1, 0}),
          about(120, {1, 1, 1}),          about(77, {1, -2, 0.5}), about(140, {-1, 0.3, 0.2})};
}

Eigen::Vector3d Up(const UpCandidate& candidate) {
  return candidate.R_level_odom.inverse() * Eigen::Vector3d::UnitZ();
}

double Angle(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return std::acos(std::clamp(a.dot(b), -1.0, 1.0));
}

// Index of the candidate within 2 degrees of the truth; candidates.size() when there is none.
size_t Rank(const std::vector<UpCandidate>& candidates, const Eigen::Vector3d& up) {
  return std::find_if(candidates.begin(), candidates.end(),
                      [&](const UpCandidate& c) { return Angle(Up(c), up) < 2 * kRadPerDeg; }) -
         candidates.begin();
}

TEST(UpCandidatesTest, FindsUpAmongWallsFloorsAndCeilings) {
  const View level = LookAtGallery();
  for (const Eigen::Quaterniond& turn : Turns()) {
    const View view = level.Turned(turn);
    EXPECT_LT(Rank(FindUpCandidates(view.surface, 3), view.up), 3u) << turn.coeffs().transpose();
  }
}

TEST(UpCandidatesTest, WhereTheSensorsWereTellsFloorFromCeiling) {
  const View level = LookAtGallery();
  for (const Eigen::Quaterniond& turn : Turns()) {
    const View view = level.Turned(turn);
    const auto candidates = FindUpCandidates(view.surface, 3, view.sensors);
    EXPECT_EQ(Rank(candidates, view.up), 0u) << turn.coeffs().transpose();
  }
}

TEST(UpCandidatesTest, OutdoorsUpIsFirst) {
  const View level = LookAtYard();
  for (const Eigen::Quaterniond& turn : Turns()) {
    const View view = level.Turned(turn);
    EXPECT_EQ(Rank(FindUpCandidates(view.surface, 3), view.up), 0u) << turn.coeffs().transpose();
  }
}

TEST(UpCandidatesTest, CandidatesAreOrderedDistinctSmallestRotations) {
  const View view = LookAtGallery().Turned(Turns()[7]);
  const auto candidates = FindUpCandidates(view.surface, 6);
  ASSERT_EQ(candidates.size(), 6u);
  for (size_t i = 0; i < candidates.size(); ++i) {
    EXPECT_GE(candidates[i].score, 0);
    EXPECT_LE(candidates[i].score, 1);
    EXPECT_NEAR(candidates[i].R_level_odom.angularDistance(Eigen::Quaterniond::Identity()),
                Angle(Up(candidates[i]), Eigen::Vector3d::UnitZ()), 1e-6);
    for (size_t j = 0; j < i; ++j) {
      EXPECT_LE(candidates[i].score, candidates[j].score);
      EXPECT_GT(Angle(Up(candidates[i]), Up(candidates[j])), 9.9 * kRadPerDeg);
    }
  }
}

TEST(UpCandidatesTest, TheNumberIsLimited) {
  const View view = LookAtGallery();
  EXPECT_TRUE(FindUpCandidates(view.surface, 0).empty());
  EXPECT_EQ(FindUpCandidates(view.surface, 1).size(), 1u);
  EXPECT_EQ(FindUpCandidates(view.surface, 2).size(), 2u);
}

TEST(UpCandidatesTest, TooLittleSurfaceLeavesOdomAsItIs) {
  std::vector<SurfacePoint> few = LookAtGallery().surface;
  few.resize(20);
  for (const auto& surface : {std::vector<SurfacePoint>(), few}) {
    const auto candidates = FindUpCandidates(surface, 3);
    ASSERT_EQ(candidates.size(), 1u);
    EXPECT_EQ(candidates[0].score, 0);
    EXPECT_TRUE(candidates[0].R_level_odom.isApprox(Eigen::Quaterniond::Identity()));
    EXPECT_FALSE(IsGravityKnown(surface));
  }
}

// A sensor that saw less of the floor than of the ceiling: down looks better.
TEST(UpCandidatesTest, OdomsOwnUpIsKeptWhereItCouldBeRight) {
  View view = LookAtGallery();
  std::erase_if(view.surface, [](const SurfacePoint& point) {
    return point.normal.z() > 0.9f && point.position.x() > 18;
  });
  const auto all = FindUpCandidates(view.surface, 6);
  ASSERT_EQ(Rank(all, view.up), 1u);
  ASSERT_GT(all[1].score, 0.5 * all[0].score);
  const auto only = FindUpCandidates(view.surface, 1);
  ASSERT_EQ(only.size(), 1u);
  EXPECT_EQ(Rank(only, view.up), 0u);
}

TEST(UpCandidatesTest, GravityIsKnownNearLevelOnly) {
  for (const View& level : {LookAtGallery(), LookAtYard()}) {
    for (const double tilt : {0.0, 5.0, -9.0, 14.0}) {
      const Eigen::Quaterniond by(
          Eigen::AngleAxisd(tilt * kRadPerDeg, Eigen::Vector3d(1, 0.4, 0).normalized()));
      const View view = level.Turned(by);
      EXPECT_TRUE(IsGravityKnown(view.surface, 0.3, view.sensors)) << tilt;
    }
    for (const Eigen::Quaterniond& turn : Turns()) {
      const View view = level.Turned(turn);
      const bool is_level = Angle(view.up, Eigen::Vector3d::UnitZ()) < 0.3;
      EXPECT_EQ(IsGravityKnown(view.surface, 0.3, view.sensors), is_level)
          << turn.coeffs().transpose();
    }
  }
}

// How far odom's z may be off is the caller's to say.
TEST(UpCandidatesTest, TheLimitOfTiltIsKept) {
  const View view = LookAtYard().Turned(
      Eigen::Quaterniond(Eigen::AngleAxisd(14 * kRadPerDeg, Eigen::Vector3d::UnitX())));
  EXPECT_TRUE(IsGravityKnown(view.surface, 15 * kRadPerDeg));
  EXPECT_FALSE(IsGravityKnown(view.surface, 13 * kRadPerDeg));
}

}  // namespace
}  // namespace isthmus::matching
