// The pose of each cloud.
#include "client/cloud_upload/cloud_poses.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

namespace isthmus::cloud_upload {
namespace {

using testing::HasSubstr;

constexpr int64_t kMs = 1'000'000;

// At x = seconds.
StampedPose AtMs(int64_t ms) {
  return {ms * kMs, Pose(Eigen::Vector3d(1e-3 * static_cast<double>(ms), 0, 0))};
}

PoseFile Stamped(const std::vector<int64_t>& stamps_ms) {
  PoseFile file{PoseFormat::kTum, true, {}};
  for (const int64_t ms : stamps_ms) file.poses.push_back(AtMs(ms));
  return file;
}

PoseFile Bare(size_t count, PoseFormat format = PoseFormat::kKitti) {
  PoseFile file{format, false, {}};
  for (size_t i = 0; i < count; ++i) {
    file.poses.push_back({0, Pose(Eigen::Vector3d(static_cast<double>(i), 0, 0))});
  }
  return file;
}

double XOf(const std::optional<StampedPose>& pose) { return pose->pose.translation().x(); }

TEST(CloudPosesTest, APoseBetweenTwoIsInterpolated) {
  // Poses at 5 Hz, clouds at 10 Hz.
  const auto poses = CloudPoses::Create(Stamped({0, 200, 400}), {}, {});
  ASSERT_TRUE(poses.ok()) << poses.status();
  for (int64_t ms = 0; ms <= 400; ms += 100) {
    const auto pose = poses->Of(0, ms * kMs);
    ASSERT_TRUE(pose.has_value()) << ms;
    EXPECT_NEAR(XOf(pose), 1e-3 * static_cast<double>(ms), 1e-12);
    EXPECT_EQ(pose->stamp_ns, ms * kMs) << "the cloud's";
  }
}

TEST(CloudPosesTest, AcrossAGapOnlyTheNearestCounts) {
  const auto poses = CloudPoses::Create(Stamped({0, 1000}), {}, {});
  ASSERT_TRUE(poses.ok());
  EXPECT_DOUBLE_EQ(XOf(poses->Of(0, 50 * kMs)), 0) << "within --max-difference";
  EXPECT_FALSE(poses->Of(0, 51 * kMs).has_value());
  EXPECT_FALSE(poses->Of(0, 500 * kMs).has_value());
  EXPECT_DOUBLE_EQ(XOf(poses->Of(0, 960 * kMs)), 1);
  EXPECT_DOUBLE_EQ(XOf(poses->Of(0, 1040 * kMs)), 1) << "behind the last";
  EXPECT_FALSE(poses->Of(0, 1060 * kMs).has_value());
  EXPECT_FALSE(poses->Of(0, -60 * kMs).has_value());
}

TEST(CloudPosesTest, ExactlyHalfASecondIsStillInterpolated) {
  const auto poses = CloudPoses::Create(Stamped({0, 500, 1001}), {}, {});
  ASSERT_TRUE(poses.ok());
  EXPECT_TRUE(poses->Of(0, 250 * kMs).has_value());
  EXPECT_FALSE(poses->Of(0, 750 * kMs).has_value());
}

TEST(CloudPosesTest, PosesMayComeInAnyOrder) {
  const auto poses = CloudPoses::Create(Stamped({400, 0, 200, 100, 300}), {}, {});
  ASSERT_TRUE(poses.ok());
  for (const int64_t ms : {150, 0, 390}) {
    EXPECT_NEAR(XOf(poses->Of(0, ms * kMs)), 1e-3 * static_cast<double>(ms), 1e-12);
  }
}

TEST(CloudPosesTest, RotationsTakeTheShortWay) {
  PoseFile file{PoseFormat::kTum, true, {}};
  const Eigen::Quaterniond quarter(Eigen::AngleAxisd(1.5, Eigen::Vector3d::UnitZ()));
  file.poses = {{0, Pose()}, {100 * kMs, Pose(Eigen::Quaterniond(-quarter.coeffs()), {1, 0, 0})}};
  const auto poses = CloudPoses::Create(file, {}, {});
  ASSERT_TRUE(poses.ok());
  EXPECT_NEAR(poses->Of(0, 50 * kMs)->pose.Yaw(), 0.75, 1e-9);
}

TEST(CloudPosesTest, CloudsWithoutTimesArePairedInOrder) {
  const auto poses = CloudPoses::Create(Stamped({5000, 6000, 7000}), {false, 0, 3}, {});
  ASSERT_TRUE(poses.ok()) << poses.status();
  EXPECT_TRUE(poses->in_order());
  EXPECT_DOUBLE_EQ(XOf(poses->Of(1, 100 * kMs)), 6);
  EXPECT_EQ(poses->Of(1, 100 * kMs)->stamp_ns, 6000 * kMs) << "the pose's, which is one";
  const auto fewer = CloudPoses::Create(Stamped({5000, 6000, 7000}), {false, 0, 4}, {});
  EXPECT_TRUE(absl::IsInvalidArgument(fewer.status()));
  EXPECT_THAT(std::string(fewer.status().message()), HasSubstr("3 poses for 4 clouds"));
  EXPECT_THAT(std::string(fewer.status().message()), HasSubstr("times.txt"));
}

TEST(CloudPosesTest, APartOfARecordingKeepsItsPairs) {
  const auto from = CloudPoses::Create(Bare(10), {true, 4, 6}, {});
  ASSERT_TRUE(from.ok()) << from.status();
  EXPECT_DOUBLE_EQ(XOf(from->Of(4, 0)), 4);
  EXPECT_TRUE(CloudPoses::Create(Bare(10), {true, 4, 3, true}, {}).ok()) << "more come after";
  EXPECT_FALSE(CloudPoses::Create(Bare(6), {true, 4, 3, true}, {}).ok());
  EXPECT_FALSE(CloudPoses::Create(Bare(10), {true, 4, 7}, {}).ok());
}

TEST(CloudPosesTest, PosesWithoutStampsFitAsManyCloudsOnly) {
  const auto same = CloudPoses::Create(Bare(3), {true, 0, 3}, {});
  ASSERT_TRUE(same.ok());
  EXPECT_EQ(same->Of(2, 77)->stamp_ns, 77) << "the cloud's own";
  EXPECT_FALSE(same->Of(3, 0).has_value());
  for (const PoseFormat format : {PoseFormat::kKitti, PoseFormat::kG2o}) {
    const auto other = CloudPoses::Create(Bare(2, format), {true, 0, 3}, {});
    EXPECT_TRUE(absl::IsInvalidArgument(other.status()));
    EXPECT_THAT(std::string(other.status().message()), HasSubstr(ToString(format)));
  }
}

TEST(CloudPosesTest, KittiWithTimesGoesByTimesWhereNumbersDiffer) {
  PoseFile file = Stamped({0, 100, 200});
  file.format = PoseFormat::kKitti;
  const auto by_stamp = CloudPoses::Create(file, {true, 0, 5}, {});
  ASSERT_TRUE(by_stamp.ok()) << by_stamp.status();
  EXPECT_FALSE(by_stamp->in_order());
  EXPECT_NEAR(XOf(by_stamp->Of(3, 150 * kMs)), 0.15, 1e-12);
  const auto in_order = CloudPoses::Create(file, {true, 0, 3}, {});
  ASSERT_TRUE(in_order.ok());
  EXPECT_TRUE(in_order->in_order());
}

}  // namespace
}  // namespace isthmus::cloud_upload
