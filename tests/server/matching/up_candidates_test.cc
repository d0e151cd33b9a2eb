#include "server/matching/search/up_candidates.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "core/geometry/angles.h"
#include "core/pose.h"
#include "server/matching/search/wall_map.h"
#include "tests/server/matching/scene.h"
#include "tests/server/matching/whole_maps.h"

namespace isthmus::matching {
namespace {

// A map's surface and sensor positions, in an odom frame that can be turned.
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
    EXPECT_LT(Rank(FindUpCandidates(view.surface), view.up), 3u) << turn.coeffs().transpose();
  }
}

TEST(UpCandidatesTest, WhereTheSensorsWereTellsFloorFromCeiling) {
  const View level = LookAtGallery();
  for (const Eigen::Quaterniond& turn : Turns()) {
    const View view = level.Turned(turn);
    const auto candidates = FindUpCandidates(view.surface, view.sensors);
    EXPECT_EQ(Rank(candidates, view.up), 0u) << turn.coeffs().transpose();
  }
}

TEST(UpCandidatesTest, OutdoorsUpIsFirst) {
  const View level = LookAtYard();
  for (const Eigen::Quaterniond& turn : Turns()) {
    const View view = level.Turned(turn);
    EXPECT_EQ(Rank(FindUpCandidates(view.surface), view.up), 0u) << turn.coeffs().transpose();
  }
}

TEST(UpCandidatesTest, CandidatesAreOrderedDistinctSmallestRotations) {
  const View view = LookAtGallery().Turned(Turns()[7]);
  const auto candidates = FindUpCandidates(view.surface);
  ASSERT_GE(candidates.size(), 6u);
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

TEST(UpCandidatesTest, TooLittleSurfaceLeavesOdomAsItIs) {
  std::vector<SurfacePoint> few = LookAtGallery().surface;
  few.resize(20);
  for (const auto& surface : {std::vector<SurfacePoint>(), few}) {
    const auto candidates = FindUpCandidates(surface);
    ASSERT_EQ(candidates.size(), 1u);
    EXPECT_EQ(candidates[0].score, 0);
    EXPECT_TRUE(candidates[0].R_level_odom.isApprox(Eigen::Quaterniond::Identity()));
    EXPECT_TRUE(LikeliestUp(candidates).R_level_odom.isApprox(Eigen::Quaterniond::Identity()));
  }
}

// The error of LikeliestUp, radians.
double ErrorOfUp(const View& view) {
  return Angle(Up(LikeliestUp(FindUpCandidates(view.surface, view.sensors))), view.up);
}

TEST(UpCandidatesTest, ALeaningSensorIsTakenToStand) {
  for (const View& level : {LookAtGallery(), LookAtYard()}) {
    for (const double tilt : {0.0, 5.0, -9.0, 19.0, 27.0}) {
      const Eigen::Quaterniond by(
          Eigen::AngleAxisd(tilt * kRadPerDeg, Eigen::Vector3d(1, 0.4, 0).normalized()));
      EXPECT_LT(ErrorOfUp(level.Turned(by)), 2 * kRadPerDeg) << tilt;
    }
  }
}

// Under the sky a floor is no ceiling; under a roof a sensor that hangs is taken to stand.
TEST(UpCandidatesTest, ASensorMayPointAnywhere) {
  for (const Eigen::Quaterniond& turn : Turns()) {
    EXPECT_LT(ErrorOfUp(LookAtYard().Turned(turn)), 2 * kRadPerDeg) << turn.coeffs().transpose();
    const View gallery = LookAtGallery().Turned(turn);
    const double error = ErrorOfUp(gallery);
    const bool hangs = gallery.up.z() < -0.5;
    EXPECT_LT(hangs ? std::numbers::pi - error : error, 2 * kRadPerDeg)
        << turn.coeffs().transpose();
  }
}

// A sensor in a furnished room sees less of the floor than of the ceiling: down looks better.
TEST(UpCandidatesTest, AClutteredFloorDoesNotTurnAMapOver) {
  View view = LookAtGallery();
  size_t floor = 0;
  std::erase_if(view.surface, [&](const SurfacePoint& point) {
    return point.normal.z() > 0.9f && ++floor % 8 != 0;
  });
  ASSERT_GT(Rank(FindUpCandidates(view.surface, view.sensors), view.up), 0u);
  EXPECT_LT(ErrorOfUp(view), 2 * kRadPerDeg);
}

// A room as high as it is long and wide, and a sensor that lies on its side.
TEST(UpCandidatesTest, NobodyDrivesUpTheVertical) {
  Scene cube;
  for (const double side : {-4.0, 4.0}) {
    cube.boxes.push_back({{side, 0, 0}, {0.1, 4, 4}});
    cube.boxes.push_back({{0, side, 0}, {4, 0.1, 4}});
    cube.boxes.push_back({{0, 0, side}, {4, 4, 0.1}});
  }
  const View view = Look(cube, Way({{-2.5, 0, 0}, {2.5, 0.2, 0}}, 15), 0.25)
                        .Turned(Eigen::Quaterniond(Eigen::AngleAxisd(
                            -90 * kRadPerDeg, Eigen::Vector3d::UnitY())));  // x becomes z.
  const Eigen::Vector3d up = Up(LikeliestUp(FindUpCandidates(view.surface, view.sensors)));
  EXPECT_LT(std::abs(up.z()), 0.1) << up.transpose();
}

}  // namespace
}  // namespace isthmus::matching
