// The stages of the feature chain that look at one map: voxel filter to FPFH.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

#include "server/matching/paper/fpfh.h"
#include "server/matching/paper/harris.h"
#include "server/matching/paper/normals.h"
#include "server/matching/paper/outlier_removal.h"
#include "server/matching/registration/voxel_filter.h"
#include "tests/server/matching/scene.h"

namespace isthmus::matching {
namespace {

// A wall in the plane x = 5, 4 m wide and high, seen from `sensor`, with submap = odom.
SessionMap FlatWall(const Eigen::Vector3d& sensor) {
  auto submap = std::make_shared<Submap>();
  submap->keyframes.push_back({1, 0, Pose(sensor)});
  for (float y = -2; y <= 2; y += 0.1f) {
    for (float z = -2; z <= 2; z += 0.1f) submap->points.push_back({5, y, z, 0, 0});
  }
  return {SessionId("wall-1"), {submap}};
}

TEST(FilterVoxels, OnePointPerVoxelAtTheMean) {
  SessionMap map = FlatWall({0, 0, 0});
  auto submap = std::make_shared<Submap>(*map.submaps[0]);
  submap->points = {{1.1f, 1.1f, 1.1f, 0, 0}, {1.3f, 1.3f, 1.1f, 0, 0}, {9, 9, 9, 0, 0}};
  const auto points = FilterVoxels({map.session, {submap}}, 1.0);
  ASSERT_EQ(points.size(), 2u);
  EXPECT_TRUE(points[0].position.isApprox(Eigen::Vector3f(1.2f, 1.2f, 1.1f), 1e-5f));
  EXPECT_LT(points[0].to_sensor.dot(points[0].position), 0);
}

TEST(FilterVoxels, JoinsSubmapsInTheOdomFrame) {
  const SessionMap wall = FlatWall({0, 0, 0});
  auto moved = std::make_shared<Submap>(*wall.submaps[0]);
  moved->T_odom_submap = Pose::FromXyzRpy(0, 0, 0, 0, 0, M_PI);
  const auto points = FilterVoxels({wall.session, {wall.submaps[0], moved}}, 0.5);
  float low = 0, high = 0;
  for (const ViewedPoint& point : points) {
    low = std::min(low, point.position.x());
    high = std::max(high, point.position.x());
  }
  EXPECT_NEAR(low, -5, 1e-4);
  EXPECT_NEAR(high, 5, 1e-4);
}

TEST(FilterVoxels, LeavesOutWhatCannotBeUsed) {
  auto submap = std::make_shared<Submap>();
  submap->keyframes.push_back({});
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float inf = std::numeric_limits<float>::infinity();
  submap->points = {
      {nan, 0, 0, 0, 0}, {0, inf, 0, 0, 0}, {1e30f, 0, 0, 0, 0}, {1, 0, 0, 0, 7}, {2, 0, 0, 0, 0}};
  const auto points = FilterVoxels({SessionId("x-1"), {submap}}, 0.5);
  ASSERT_EQ(points.size(), 1u);
  EXPECT_EQ(points[0].position.x(), 2);
}

TEST(RemoveOutliers, DropsTheLonelyPoint) {
  std::vector<ViewedPoint> points = FilterVoxels(FlatWall({0, 0, 0}), 0.2);
  const size_t wall = points.size();
  points.push_back({{0, 0, 20}, {0, 0, -1}});
  const auto kept = RemoveOutliers(points, {});
  EXPECT_GT(kept.size(), 0.9 * static_cast<double>(wall));
  for (const ViewedPoint& point : kept) EXPECT_LT(point.position.z(), 10);
}

TEST(EstimateNormals, FaceTheSensorOnWhicheverSideOfTheWallItStood) {
  for (const double x : {0.0, 12.0}) {  // The origin is on the near side of the wall both times.
    const OrientedPoints points = EstimateNormals(FilterVoxels(FlatWall({x, 0.5, 0}), 0.2), {});
    ASSERT_GT(points.normals.size(), 100u);
    for (const Eigen::Vector3f& normal : points.normals) {
      EXPECT_NEAR(normal.x(), x < 5 ? -1 : 1, 1e-3);
    }
  }
}

TEST(EstimateNormals, APointAloneHasNone) {
  EXPECT_TRUE(EstimateNormals({{{0, 0, 0}, {0, 0, 1}}}, {}).positions.empty());
  EXPECT_TRUE(EstimateNormals({}, {}).positions.empty());
}

OrientedPoints Gallery() {
  const Drive drive{Way({{3, 3, 1}, {10, 6, 1}}, 8), Pose()};
  return EstimateNormals(FilterVoxels(Survey(MakeGallery(), drive), 0.3), {});
}

TEST(DetectHarrisKeypoints, SitWhereSurfacesMeet) {
  const OrientedPoints flat = EstimateNormals(FilterVoxels(FlatWall({0, 0, 0}), 0.2), {});
  EXPECT_TRUE(DetectHarrisKeypoints(flat, {}).empty());
  const OrientedPoints gallery = Gallery();
  const auto keypoints = DetectHarrisKeypoints(gallery, {});
  EXPECT_GT(keypoints.size(), 20u);
  EXPECT_LT(keypoints.size(), gallery.positions.size() / 5);
  EXPECT_TRUE(std::is_sorted(keypoints.begin(), keypoints.end()));
}

TEST(DetectHarrisKeypoints, KeepsTheStrongest) {
  HarrisOptions options;
  options.max_keypoints = 10;
  EXPECT_EQ(DetectHarrisKeypoints(Gallery(), options).size(), 10u);
  EXPECT_TRUE(DetectHarrisKeypoints({}, options).empty());
}

TEST(DescribeFpfh, StaysTheSameWhenTheMapIsTurned) {
  const OrientedPoints points = Gallery();
  const auto keypoints = DetectHarrisKeypoints(points, {});
  OrientedPoints turned = points;
  const Eigen::Matrix3f R = Pose::FromXyzRpy(0, 0, 0, 0.2, 0.1, 2.0).RotationMatrix().cast<float>();
  for (Eigen::Vector3f& p : turned.positions) p = R * p + Eigen::Vector3f(20, -5, 1);
  for (Eigen::Vector3f& n : turned.normals) n = R * n;
  FpfhOptions all_points;
  all_points.surface_voxel_m = 0;  // A grid would pick other points of the turned map.
  const auto before = DescribeFpfh(points, keypoints, all_points);
  const auto after = DescribeFpfh(turned, keypoints, all_points);
  ASSERT_EQ(before.size(), keypoints.size());
  ASSERT_EQ(after.size(), keypoints.size());
  double difference = 0, size = 0;
  for (size_t i = 0; i < before.size(); ++i) {
    difference += (before[i] - after[i]).norm();
    size += before[i].norm();
  }
  EXPECT_LT(difference, 0.05 * size);
}

TEST(DescribeFpfh, HistogramsAddUp) {
  const OrientedPoints points = Gallery();
  for (const FpfhDescriptor& d : DescribeFpfh(points, DetectHarrisKeypoints(points, {}), {})) {
    for (int feature = 0; feature < 3; ++feature) {
      EXPECT_NEAR(d.segment<11>(11 * feature).sum(), 100, 0.1);
    }
  }
  EXPECT_TRUE(DescribeFpfh(points, {}, {}).empty());
}

}  // namespace
}  // namespace isthmus::matching
