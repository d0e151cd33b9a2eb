// Clouds with poses, cut into submaps.
#include "client/cloud_upload/submap_cutter.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <set>

#include "core/codec/payload_builder.h"
#include "core/codec/payload_layout.h"

namespace isthmus::cloud_upload {
namespace {

constexpr int64_t kTenthNs = 100'000'000;

// A drive in a curve that climbs, far from the origin, a metre and 0.1 s per step.
StampedPose Step(int i) {
  const double a = 0.05 * i;
  return {i * kTenthNs,
          Pose::FromXyzRpy(500'000 + 20 * std::sin(a), 20 * std::cos(a), 0.1 * i, 0.05, -0.1, -a)};
}

// Points of the world within sight of a pose: each has an intensity of its own.
Cloud Around(const Pose& T_odom_sensor, int step, const Pose& T_frame_odom) {
  Cloud cloud;
  for (int k = 0; k < 12; ++k) {
    const Eigen::Vector3d in_sensor(3 + k, 2 * std::sin(k), 0.3 * k);
    const Eigen::Vector3f p = (T_frame_odom * (T_odom_sensor * in_sensor)).cast<float>();
    cloud.push_back({p.x(), p.y(), p.z(), static_cast<float>(100 * step + k)});
  }
  return cloud;
}

std::vector<SubmapUpload> CutAll(SubmapCutter& cutter, int steps, bool in_odom = false) {
  std::vector<SubmapUpload> all;
  for (int i = 0; i < steps; ++i) {
    const StampedPose at = Step(i);
    PointPayload cloud =
        codec::MakePayload(Around(at.pose, i, in_odom ? Pose() : at.pose.Inverse()));
    auto completed = cutter.Add(at, cloud);
    EXPECT_TRUE(completed.ok()) << completed.status();
    for (SubmapUpload& submap : *completed) all.push_back(std::move(submap));
  }
  if (auto last = cutter.Finish()) all.push_back(*std::move(last));
  return all;
}

std::vector<double> ColumnOf(const SubmapUpload& submap, const char* name) {
  return codec::ReadColumn(submap.cloud, *codec::FindField(submap.cloud, {name}));
}

TEST(SubmapCutterTest, EveryPointIsThereOnceWhereItWasInTheWorld) {
  SubmapCutter cutter({.voxel_m = 0});
  const std::vector<SubmapUpload> submaps = CutAll(cutter, 70);
  ASSERT_GE(submaps.size(), 4u) << "70 m";
  std::set<double> seen;
  for (const SubmapUpload& submap : submaps) {
    ASSERT_TRUE(codec::CheckLayout(submap.cloud).ok());
    const auto x = ColumnOf(submap, "x"), y = ColumnOf(submap, "y"), z = ColumnOf(submap, "z");
    const auto id = ColumnOf(submap, "intensity"), keyframe = ColumnOf(submap, "keyframe");
    for (size_t p = 0; p < x.size(); ++p) {
      EXPECT_TRUE(seen.insert(id[p]).second) << "twice: " << id[p];
      const int step = static_cast<int>(id[p]) / 100, k = static_cast<int>(id[p]) % 100;
      const Eigen::Vector3d truth =
          Step(step).pose * Eigen::Vector3d(3 + k, 2 * std::sin(k), 0.3 * k);
      const Eigen::Vector3d world = submap.T_odom_submap * Eigen::Vector3d(x[p], y[p], z[p]);
      EXPECT_LT((world - truth).norm(), 1e-4);
      // The keyframe that it names is the place that it was seen from.
      ASSERT_LT(keyframe[p], submap.keyframes.size());
      const StampedPose& from = submap.keyframes[static_cast<size_t>(keyframe[p])];
      EXPECT_EQ(from.stamp_ns, Step(step).stamp_ns);
      const Pose T_odom_sensor = submap.T_odom_submap * from.pose;
      EXPECT_TRUE(T_odom_sensor.Matrix().isApprox(Step(step).pose.Matrix(), 1e-9));
    }
  }
  EXPECT_EQ(seen.size(), cutter.points());
  EXPECT_EQ(seen.size(), 12 * cutter.keyframes());
}

TEST(SubmapCutterTest, SubmapsFollowEachOtherAndBeginWithAKeyframe) {
  SubmapCutter cutter({});
  const std::vector<SubmapUpload> submaps = CutAll(cutter, 40);
  for (size_t i = 0; i < submaps.size(); ++i) {
    EXPECT_EQ(submaps[i].id.index, i);
    ASSERT_FALSE(submaps[i].keyframes.empty());
    EXPECT_TRUE(submaps[i].keyframes[0].pose.Matrix().isIdentity(1e-9));
    EXPECT_EQ(submaps[i].keyframes[0].stamp_ns, submaps[i].first_stamp_ns);
    EXPECT_GE(submaps[i].last_stamp_ns, submaps[i].keyframes.back().stamp_ns);
    if (i == 0) continue;
    EXPECT_GT(submaps[i].first_stamp_ns, submaps[i - 1].last_stamp_ns);
  }
  EXPECT_EQ(submaps.back().last_stamp_ns, Step(39).stamp_ns);
  EXPECT_NEAR(cutter.travelled_m(), 39, 0.5);
}

TEST(SubmapCutterTest, CloudsInTheOdomFrameGiveTheSameSubmaps) {
  // Near the origin, where float coordinates of the odom frame do.
  const StampedPose at{0, Pose::FromXyzRpy(3, -4, 1, 0.1, 0.2, 2)};
  SubmapCutter in_sensor({.voxel_m = 0}), in_odom({.frame = CloudFrame::kOdom, .voxel_m = 0});
  ASSERT_TRUE(in_sensor.Add(at, codec::MakePayload(Around(at.pose, 0, at.pose.Inverse()))).ok());
  ASSERT_TRUE(in_odom.Add(at, codec::MakePayload(Around(at.pose, 0, Pose()))).ok());
  const SubmapUpload a = *in_sensor.Finish(), b = *in_odom.Finish();
  ASSERT_EQ(a.cloud.width, b.cloud.width);
  for (const char* name : {"x", "y", "z", "intensity"}) {
    const auto va = ColumnOf(a, name), vb = ColumnOf(b, name);
    for (size_t i = 0; i < va.size(); ++i) EXPECT_NEAR(va[i], vb[i], 1e-5);
  }
}

TEST(SubmapCutterTest, TheSameCloudsGiveTheSameBytes) {
  SubmapCutter one({}), two({});
  const auto a = CutAll(one, 30), b = CutAll(two, 30);
  ASSERT_EQ(a.size(), b.size());
  for (size_t i = 0; i < a.size(); ++i) EXPECT_EQ(a[i].cloud.data, b[i].cloud.data);
}

TEST(SubmapCutterTest, UselessPointsAreLeftOut) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float inf = std::numeric_limits<float>::infinity();
  SubmapCutter cutter({.voxel_m = 0.5, .range_m = 50});
  ASSERT_TRUE(cutter
                  .Add({}, codec::MakePayload(Cloud{{nan, 1, 1, 0},
                                                    {1, inf, 1, 0},
                                                    {0, 0, 0, 0},
                                                    {51, 0, 0, 0},
                                                    {49, 0, 0, nan},
                                                    {10.1F, 0.1F, 0.1F, 1},
                                                    {10.2F, 0.2F, 0.2F, 2}}))
                  .ok());
  const SubmapUpload submap = *cutter.Finish();
  EXPECT_EQ(submap.cloud.width, 2u);
  EXPECT_THAT(ColumnOf(submap, "intensity"), testing::ElementsAre(0, 1)) << "the first of a voxel";
}

TEST(SubmapCutterTest, ARobotThatStandsMakesNoKeyframesButItsTimeEndsSubmaps) {
  SubmapCutter cutter({});
  const PointPayload cloud = codec::MakePayload(Cloud{{5, 0, 0, 0}});
  size_t submaps = 0;
  for (int i = 0; i < 500; ++i) {
    const Pose trembling(Eigen::Vector3d(i % 2 == 0 ? 0.01 : 0, 0, 0));
    submaps += cutter.Add({i * kTenthNs, trembling}, cloud)->size();
  }
  submaps += cutter.Finish() ? 1 : 0;
  EXPECT_EQ(submaps, 3u) << "50 s";
  EXPECT_EQ(cutter.keyframes(), submaps);
}

TEST(SubmapCutterTest, ACloudOfMorePointsThanASubmapBecomesSeveral) {
  SubmapCutter cutter({.points = 10, .voxel_m = 0});
  Cloud cloud;
  for (int i = 0; i < 35; ++i) cloud.push_back({1 + 0.5F * static_cast<float>(i), 0, 0, 0});
  const StampedPose at{5, Pose::FromXyzRpy(1, 2, 3, 0, 0, 1)};
  auto submaps = *cutter.Add(at, codec::MakePayload(cloud));
  submaps.push_back(*cutter.Finish());
  ASSERT_EQ(submaps.size(), 4u);
  size_t points = 0;
  for (size_t i = 0; i < submaps.size(); ++i) {
    EXPECT_EQ(submaps[i].id.index, i);
    EXPECT_EQ(submaps[i].keyframes.size(), 1u);
    EXPECT_TRUE(submaps[i].T_odom_submap.Matrix().isApprox(at.pose.Matrix()));
    points += submaps[i].cloud.width;
  }
  EXPECT_EQ(points, 35u);
}

TEST(SubmapCutterTest, CloudsThatCannotBeUsedChangeNothing) {
  SubmapCutter cutter({});
  PointPayload flat = codec::MakePayload(Cloud{{1, 1, 1, 0}});
  flat.fields[2].name = "height";
  const auto refused = cutter.Add({}, flat);
  EXPECT_TRUE(absl::IsInvalidArgument(refused.status()));
  EXPECT_THAT(std::string(refused.status().message()), testing::HasSubstr("no field z"));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(cutter.Add({0, Pose(Eigen::Vector3d(nan, 0, 0))}, flat).ok());
  EXPECT_TRUE(cutter.Add({}, codec::MakePayload(Cloud{{100, 0, 0, 0}})).ok());
  EXPECT_EQ(cutter.without_points(), 1u);
  EXPECT_FALSE(cutter.Finish().has_value());
}

TEST(SubmapCutterTest, OptionsThatTheGridCannotHoldAreRefused) {
  EXPECT_TRUE(CheckOptions({}).ok());
  EXPECT_TRUE(CheckOptions({.voxel_m = 0}).ok());
  EXPECT_FALSE(CheckOptions({.voxel_m = -0.1}).ok());
  EXPECT_FALSE(CheckOptions({.voxel_m = 0.001}).ok());
  EXPECT_FALSE(CheckOptions({.voxel_m = 100}).ok());
  EXPECT_FALSE(CheckOptions({.range_m = 0}).ok());
  EXPECT_FALSE(CheckOptions({.range_m = 501}).ok());
  EXPECT_FALSE(CheckOptions({.voxel_m = std::numeric_limits<double>::quiet_NaN()}).ok());
}

}  // namespace
}  // namespace isthmus::cloud_upload
