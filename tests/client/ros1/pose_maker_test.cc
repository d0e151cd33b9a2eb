#include "client/ros1/pose_maker.h"

#include <gtest/gtest.h>

#include "client/ros1/conversions.h"

namespace isthmus::ros1 {
namespace {

ScanAck AckOf(const char* segment, int64_t stamp_ns, const Pose& T_odom_sensor) {
  ScanAck ack;
  ack.segment_session = SessionId(segment);
  ack.end_stamp_ns = stamp_ns;
  ack.T_odom_sensor = T_odom_sensor;
  return ack;
}

const PoseMaker::Tree kTree{"lidar", Pose(Eigen::Vector3d(0, 0, 1)), Pose()};

TEST(Ros1PoseMaker, MapIsOdomUntilTheServerHasPlacedTheSession) {
  PoseMaker maker{FrameParameters{}};
  ScanAck ack = AckOf("a-1", 1'000'000'000, Pose(Eigen::Vector3d(2, 0, 0)));
  PoseMessages made = maker.Make(ack, kTree);
  ASSERT_EQ(made.transforms.size(), 2U);
  EXPECT_EQ(made.transforms[0].header.frame_id, "odom");
  EXPECT_EQ(made.transforms[0].child_frame_id, "base_link");
  EXPECT_EQ(made.transforms[0].transform.translation.z, -1);  // Below the sensor.
  EXPECT_EQ(made.transforms[1].header.frame_id, "map");
  EXPECT_TRUE(ToPose(made.transforms[1].transform).Matrix().isIdentity());
  EXPECT_EQ(made.odometry->header.frame_id, "odom");

  ack.end_stamp_ns += 100'000'000;
  ack.T_map_odom = Pose(Eigen::Vector3d(7, 0, 0));
  made = maker.Make(ack, kTree);
  EXPECT_EQ(made.transforms[1].transform.translation.x, 7);
}

TEST(Ros1PoseMaker, ALaterSegmentIsInNoMapBeforeItIsJoined) {
  PoseMaker maker{FrameParameters{}};
  maker.Make(AckOf("a-1", 1'000, {}), kTree);
  ScanAck ack = AckOf("a-1.2", 2'000, {});
  ack.T_map_odom = Pose();  // In a component of its own.
  PoseMessages made = maker.Make(ack, kTree);
  ASSERT_EQ(made.transforms.size(), 1U);
  EXPECT_EQ(made.transforms[0].header.frame_id, "odom_2");
  EXPECT_EQ(made.odometry->twist.covariance[0], -1);  // Over two frames there is no velocity.
  maker.SetJoined({SessionId("a-1"), SessionId("a-1.2")});
  ack.end_stamp_ns = 3'000;
  made = maker.Make(ack, kTree);
  ASSERT_EQ(made.transforms.size(), 2U);
  EXPECT_EQ(made.transforms[1].child_frame_id, "odom_2");
}

TEST(Ros1PoseMaker, LeavesOdomToTheRobotWhereItHasOne) {
  FrameParameters frames;
  frames.publish_odom_tf = false;
  PoseMaker maker(frames);
  PoseMaker::Tree tree = kTree;
  tree.T_odom_base = Pose::FromXyzRpy(5, 5, 0, 0, 0, 1);
  ScanAck ack = AckOf("a-1", 1'000, Pose(Eigen::Vector3d(2, 0, 1)));
  ack.T_map_odom = Pose(Eigen::Vector3d(10, 0, 0));
  const PoseMessages made = maker.Make(ack, tree);
  ASSERT_EQ(made.transforms.size(), 1U);
  const Pose T_map_base = ToPose(made.transforms[0].transform) * *tree.T_odom_base;
  EXPECT_TRUE(T_map_base.translation().isApprox(Eigen::Vector3d(12, 0, 0), 1e-9));
  EXPECT_EQ(made.odometry->header.frame_id, "map");
  EXPECT_NEAR(made.odometry->pose.pose.position.x, 12, 1e-9);
}

TEST(Ros1PoseMaker, NothingIsSaidTwiceOrWithoutAPose) {
  PoseMaker maker{FrameParameters{}};
  const ScanAck ack = AckOf("a-1", 1'000, {});
  EXPECT_TRUE(maker.Make(ack, kTree).odometry.has_value());
  EXPECT_FALSE(maker.Make(ack, kTree).odometry.has_value());
  ScanAck rejected = AckOf("a-1", 2'000, {});
  rejected.T_odom_sensor.reset();
  EXPECT_TRUE(maker.Make(rejected, kTree).transforms.empty());
}

}  // namespace
}  // namespace isthmus::ros1
