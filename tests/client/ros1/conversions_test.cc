#include "client/ros1/conversions.h"

#include <gtest/gtest.h>

namespace isthmus::ros1 {
namespace {

TEST(Ros1Conversions, TransformsComeBackAsTheyWere) {
  const Pose pose = Pose::FromXyzRpy(1, -2, 3, 0.1, -0.2, 2.5);
  EXPECT_TRUE(ToPose(ToTransform(pose)).Matrix().isApprox(pose.Matrix(), 1e-12));
  EXPECT_TRUE(ToPose({}).Matrix().isIdentity());  // A rotation of zero.
}

TEST(Ros1Conversions, StampsThatRosCannotSayAreTheNearest) {
  EXPECT_EQ(ToTime(1'700'000'000'123'456'789), ros::Time(1'700'000'000, 123'456'789));
  EXPECT_EQ(ToTime(-5), ros::Time(0, 0));
  EXPECT_EQ(ToTime(INT64_MAX), ros::Time(UINT32_MAX, 0));
}

// By moving the sensor a little in its own frame, and looking at where the base goes in odom.
TEST(Ros1Conversions, CovarianceIsOfTheBaseAboutTheAxesOfOdom) {
  const Pose T_odom_sensor = Pose::FromXyzRpy(4, 5, 0, 0.1, 0.2, 1.2);
  const Pose T_base_sensor = Pose::FromXyzRpy(0.3, 0, 1.5, 0, 0.1, 0.4);
  const Pose T_odom_base = T_odom_sensor * T_base_sensor.Inverse();
  Matrix6d jacobian;
  for (int i = 0; i < 6; ++i) {
    constexpr double step = 1e-6;
    const Pose moved = T_odom_sensor * Exp(step * Vector6d::Unit(i)) * T_base_sensor.Inverse();
    jacobian.col(i).head<3>() = (moved.translation() - T_odom_base.translation()) / step;
    jacobian.col(i).tail<3>() =
        Log(Pose(moved.rotation() * T_odom_base.rotation().conjugate(), {0, 0, 0})).tail<3>() /
        step;
  }
  Vector6d variances;
  variances << 1, 2, 3, 0.1, 0.2, 0.3;
  const Matrix6d covariance = variances.asDiagonal();
  nav_msgs::Odometry message;
  SetPose(T_odom_sensor, covariance, T_base_sensor, message);
  const Matrix6d expected = jacobian * covariance * jacobian.transpose();
  const Eigen::Map<const Matrix6d> actual(message.pose.covariance.data());
  EXPECT_TRUE(actual.isApprox(expected, 1e-4)) << actual << "\n\n" << expected;
  EXPECT_NEAR(message.pose.pose.position.x, T_odom_base.translation().x(), 1e-12);
}

TEST(Ros1Conversions, VelocityIsInTheFrameOfTheBase) {
  const Pose before = Pose::FromXyzRpy(1, 1, 0, 0, 0, 1.57);
  nav_msgs::Odometry message;
  SetTwist(before, before * Pose(Eigen::Vector3d(0.2, 0, 0)), 0.1, message);
  EXPECT_NEAR(message.twist.twist.linear.x, 2, 1e-9);
  EXPECT_NEAR(message.twist.twist.linear.y, 0, 1e-9);
}

}  // namespace
}  // namespace isthmus::ros1
