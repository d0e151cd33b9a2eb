#include "floam/submap_builder.h"

#include <gtest/gtest.h>

#include <cmath>

namespace isthmus::floam {
namespace {

// A scan at x metres along a straight way, seeing a patch of wall to its left.
OdometryResult ScanAt(uint64_t sequence, double x) {
  OdometryResult result;
  result.sequence = sequence;
  result.stamp_ns = static_cast<int64_t>(sequence) * 100'000'000;
  result.T_odom_sensor = Pose::FromXyzRpy(x, 0, 0, 0, 0, 0.5);
  for (int k = 0; k < 100; ++k) {
    result.undistorted.push_back({2, static_cast<float>(k) * 0.05F, 0.3F, 7});
  }
  result.undistorted.push_back({90, 0, 0, 7});  // Beyond max_range_m.
  return result;
}

SubmapBuilder Builder(SubmapOptions options = {}, uint32_t first = 0) {
  return SubmapBuilder(SessionId("alice-1"), RobotId("alice"), options, first);
}

TEST(SubmapBuilder, CutsByDistance) {
  SubmapBuilder builder = Builder();
  std::vector<std::shared_ptr<const Submap>> submaps;
  for (int k = 0; k < 100; ++k) {
    if (auto submap = builder.Add(ScanAt(k, 0.502 * k))) submaps.push_back(submap);
  }
  ASSERT_EQ(submaps.size(), 3u);  // 49.7 m.
  for (size_t i = 0; i < submaps.size(); ++i) {
    const Submap& submap = *submaps[i];
    EXPECT_EQ(submap.id, (SubmapId{SessionId("alice-1"), static_cast<uint32_t>(i)}));
    EXPECT_EQ(submap.robot, RobotId("alice"));
    EXPECT_EQ(submap.last_sequence - submap.first_sequence, 30u);
    EXPECT_EQ(submap.keyframes.size(), 16u);
    if (i > 0) {
      EXPECT_EQ(submap.first_sequence, submaps[i - 1]->last_sequence + 1);
    }
  }
  EXPECT_EQ(builder.CurrentIndex(), 3u);
}

TEST(SubmapBuilder, CutsByScans) {
  SubmapOptions options;
  options.cut_scans = 40;
  SubmapBuilder builder = Builder(options, 5);
  for (int k = 0; k < 39; ++k) EXPECT_EQ(builder.Add(ScanAt(k, 0)), nullptr);
  const auto submap = builder.Add(ScanAt(39, 0));
  ASSERT_NE(submap, nullptr);
  EXPECT_EQ(submap->id.index, 5u);
  EXPECT_EQ(submap->keyframes.size(), 1u) << "standing still adds no keyframes";
  EXPECT_EQ(submap->first_stamp_ns, 0);
  EXPECT_EQ(submap->last_stamp_ns, 3'900'000'000);
}

TEST(SubmapBuilder, PointsAreThinnedAndGroupedByKeyframe) {
  SubmapOptions options;
  options.resolution_m = 0;
  SubmapBuilder builder = Builder(options);
  for (int k = 0; k < 10; ++k) EXPECT_EQ(builder.Add(ScanAt(k, 0.5 * k)), nullptr);
  const auto submap = builder.Finish();
  ASSERT_NE(submap, nullptr);
  ASSERT_EQ(submap->keyframes.size(), 5u);
  std::vector<int> count(5, 0);
  uint16_t last = 0;
  for (const SubmapPoint& p : submap->points) {
    ASSERT_LT(p.keyframe, 5);
    EXPECT_GE(p.keyframe, last);
    last = p.keyframe;
    ++count[p.keyframe];
    // Back where the sensor saw it.
    const Eigen::Vector3d seen =
        submap->keyframes[p.keyframe].T_submap_sensor.Inverse() * p.Position().cast<double>();
    EXPECT_NEAR(seen.x(), 2, 1e-4);
    EXPECT_NEAR(seen.z(), 0.3, 1e-4);
  }
  for (const int points : count) EXPECT_NEAR(points, 5 / 0.15, 2);
}

// As the store rounds them, so that a restart changes nothing.
TEST(SubmapBuilder, PointsAreRoundedToTheResolution) {
  SubmapOptions exact, rounded;
  exact.resolution_m = 0;
  SubmapBuilder exact_builder = Builder(exact), rounded_builder = Builder(rounded);
  for (int k = 0; k < 10; ++k) {
    exact_builder.Add(ScanAt(k, 0.517 * k));
    rounded_builder.Add(ScanAt(k, 0.517 * k));
  }
  const auto points = exact_builder.Finish()->points, rough = rounded_builder.Finish()->points;
  ASSERT_EQ(points.size(), rough.size());
  for (size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector3d steps = rough[i].Position().cast<double>() / rounded.resolution_m;
    EXPECT_LT((steps - steps.array().round().matrix()).norm(), 0.01);
    const Eigen::Vector3f off = points[i].Position() - rough[i].Position();
    EXPECT_LE(off.cwiseAbs().maxCoeff(), 0.501e-3);
  }
}

TEST(SubmapBuilder, FrameIsTheFirstKeyframe) {
  SubmapBuilder builder = Builder();
  builder.Add(ScanAt(1, 10));
  builder.Add(ScanAt(2, 11));
  const auto submap = builder.Finish();
  EXPECT_LT(Log(submap->keyframes[0].T_submap_sensor).norm(), 1e-12);
  EXPECT_EQ(submap->T_odom_submap.translation().x(), 10);
  const Pose T_odom_second = submap->T_odom_submap * submap->keyframes[1].T_submap_sensor;
  EXPECT_NEAR(T_odom_second.translation().x(), 11, 1e-9);
}

TEST(SubmapBuilder, ALostScanEndsTheSubmapBeforeIt) {
  SubmapBuilder builder = Builder();
  builder.Add(ScanAt(1, 0));
  builder.Add(ScanAt(2, 1));
  OdometryResult lost = ScanAt(3, 2);
  lost.status = TrackingStatus::kLost;
  const auto submap = builder.Add(lost);
  ASSERT_NE(submap, nullptr);
  EXPECT_EQ(submap->last_sequence, 2u);
  EXPECT_EQ(submap->keyframes.size(), 2u);
  EXPECT_EQ(builder.Add(lost), nullptr);
  EXPECT_EQ(builder.Finish(), nullptr);
  builder.Add(ScanAt(5, 4));
  EXPECT_EQ(builder.Finish()->id.index, 1u);
}

TEST(SubmapBuilder, KeyframesByTurningAndByTimeWhileMoving) {
  SubmapBuilder builder = Builder();
  builder.Add(ScanAt(0, 0));
  OdometryResult turned = ScanAt(1, 0);
  turned.T_odom_sensor = Pose::FromXyzRpy(0, 0, 0, 0, 0, 0.9);
  builder.Add(turned);
  OdometryResult crept = ScanAt(60, 0.1);
  crept.T_odom_sensor = Pose::FromXyzRpy(0.1, 0, 0, 0, 0, 0.9);
  builder.Add(crept);
  EXPECT_EQ(builder.Finish()->keyframes.size(), 3u);
}

}  // namespace
}  // namespace isthmus::floam
