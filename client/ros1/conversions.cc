#include "client/ros1/conversions.h"

#include <algorithm>
#include <limits>

#include "core/nanoseconds.h"

namespace isthmus::ros1 {
namespace {

void SetQuaternion(const Eigen::Quaterniond& q, geometry_msgs::Quaternion& message) {
  message.x = q.x();
  message.y = q.y();
  message.z = q.z();
  message.w = q.w();
}

// Takes a twist in the frame of the source to that of the target. Barfoot, "State Estimation for
// Robotics", eq. 7.47.
Matrix6d Adjoint(const Pose& T_target_source) {
  Matrix6d adjoint = Matrix6d::Zero();
  const Eigen::Matrix3d rotation = T_target_source.RotationMatrix();
  adjoint.topLeftCorner<3, 3>() = rotation;
  adjoint.bottomRightCorner<3, 3>() = rotation;
  adjoint.topRightCorner<3, 3>() = Skew(T_target_source.translation()) * rotation;
  return adjoint;
}

}  // namespace

ros::Time ToTime(int64_t stamp_ns) {
  constexpr int64_t last = std::numeric_limits<uint32_t>::max() * kNsPerSecond;
  const auto stamp = static_cast<uint64_t>(std::clamp<int64_t>(stamp_ns, 0, last));
  return {static_cast<uint32_t>(stamp / kNsPerSecond), static_cast<uint32_t>(stamp % kNsPerSecond)};
}

geometry_msgs::Transform ToTransform(const Pose& T_parent_child) {
  geometry_msgs::Transform message;
  message.translation.x = T_parent_child.translation().x();
  message.translation.y = T_parent_child.translation().y();
  message.translation.z = T_parent_child.translation().z();
  SetQuaternion(T_parent_child.rotation(), message.rotation);
  return message;
}

Pose ToPose(const geometry_msgs::Transform& T_parent_child) {
  const geometry_msgs::Vector3& t = T_parent_child.translation;
  const geometry_msgs::Quaternion& q = T_parent_child.rotation;
  Eigen::Quaterniond rotation(q.w, q.x, q.y, q.z);
  if (!(rotation.norm() > 0)) rotation.setIdentity();
  return {rotation, {t.x, t.y, t.z}};
}

geometry_msgs::TransformStamped MakeTransform(const ros::Time& stamp, const std::string& parent,
                                              const std::string& child,
                                              const Pose& T_parent_child) {
  geometry_msgs::TransformStamped message;
  message.header.stamp = stamp;
  message.header.frame_id = parent;
  message.child_frame_id = child;
  message.transform = ToTransform(T_parent_child);
  return message;
}

void SetPose(const Pose& T_odom_sensor, const Matrix6d& covariance, const Pose& T_base_sensor,
             nav_msgs::Odometry& message) {
  const Pose T_odom_base = T_odom_sensor * T_base_sensor.Inverse();
  const geometry_msgs::Transform pose = ToTransform(T_odom_base);
  message.pose.pose.position.x = pose.translation.x;
  message.pose.pose.position.y = pose.translation.y;
  message.pose.pose.position.z = pose.translation.z;
  message.pose.pose.orientation = pose.rotation;
  Matrix6d to_odom = Adjoint(T_base_sensor);
  to_odom.topRows<3>() = T_odom_base.RotationMatrix() * to_odom.topRows<3>().eval();
  to_odom.bottomRows<3>() = T_odom_base.RotationMatrix() * to_odom.bottomRows<3>().eval();
  const Matrix6d rotated = to_odom * covariance * to_odom.transpose();
  // Symmetric: the order of rows and columns does not matter.
  std::copy(rotated.data(), rotated.data() + rotated.size(), message.pose.covariance.begin());
}

void SetTwist(const Pose& T_odom_before, const Pose& T_odom_base, double seconds,
              nav_msgs::Odometry& message) {
  const Vector6d twist = Log(T_odom_before.Inverse() * T_odom_base) / seconds;
  message.twist.twist.linear.x = twist[0];
  message.twist.twist.linear.y = twist[1];
  message.twist.twist.linear.z = twist[2];
  message.twist.twist.angular.x = twist[3];
  message.twist.twist.angular.y = twist[4];
  message.twist.twist.angular.z = twist[5];
}

}  // namespace isthmus::ros1
