#include "client/ros1/pose_maker.h"

#include "client/ros1/conversions.h"
#include "client/ros1/limits.h"

namespace isthmus::ros1 {

std::optional<Pose> PoseMaker::PlaceOdom(const ScanAck& ack) const {
  if (ack.segment_session == home_) return ack.T_map_odom.value_or(Pose());
  return joined_.contains(ack.segment_session) ? ack.T_map_odom : std::nullopt;
}

nav_msgs::Odometry PoseMaker::MakeOdometry(const ScanAck& ack, const Tree& tree,
                                           const Pose& T_frame_odom) {
  nav_msgs::Odometry message;
  message.header.stamp = ToTime(ack.end_stamp_ns);
  const Pose& T_odom_sensor = *ack.T_odom_sensor;
  SetPose(T_frame_odom * T_odom_sensor, ack.covariance.value_or(Matrix6d::Zero()),
          *tree.T_base_sensor, message);
  const Pose T_odom_base = T_odom_sensor * tree.T_base_sensor->Inverse();
  const double seconds = static_cast<double>(ack.end_stamp_ns - last_ns_) * 1e-9;
  if (ack.segment_session == last_segment_ && seconds <= kMaxTwistGapS) {
    SetTwist(T_odom_last_, T_odom_base, seconds, message);
  } else {
    message.twist.covariance[0] = -1;  // Not known, as sensor_msgs/Imu says it.
  }
  last_ns_ = ack.end_stamp_ns;
  last_segment_ = ack.segment_session;
  T_odom_last_ = T_odom_base;
  return message;
}

PoseMessages PoseMaker::Make(const ScanAck& ack, const Tree& tree) {
  PoseMessages made;
  if (!ack.T_odom_sensor || !tree.T_base_sensor || ack.end_stamp_ns <= last_ns_) return made;
  if (home_.empty()) home_ = ack.segment_session;
  const std::string& base = frames_.base.empty() ? tree.sensor_frame : frames_.base;
  const std::optional<Pose> T_map_odom = PlaceOdom(ack);
  const ros::Time stamp = ToTime(ack.end_stamp_ns);
  const ros::Time ahead = stamp + ros::Duration(frames_.tolerance_s);
  nav_msgs::Odometry odometry =
      MakeOdometry(ack, tree, frames_.publish_odom_tf ? Pose() : T_map_odom.value_or(Pose()));
  odometry.child_frame_id = base;
  if (frames_.publish_odom_tf) {
    const std::string& odom = odoms_.NameOf(ack.segment_session);
    odometry.header.frame_id = odom;
    made.transforms.push_back(MakeTransform(stamp, odom, base, T_odom_last_));
    if (T_map_odom) {
      made.transforms.push_back(MakeTransform(ahead, frames_.map, odom, *T_map_odom));
    }
    made.odometry = std::move(odometry);
  } else if (T_map_odom) {
    odometry.header.frame_id = frames_.map;
    made.odometry = std::move(odometry);
    if (tree.T_odom_base) {
      const Pose T_map_odom_of_robot = *T_map_odom * T_odom_last_ * tree.T_odom_base->Inverse();
      made.transforms.push_back(
          MakeTransform(ahead, frames_.map, frames_.odom, T_map_odom_of_robot));
    }
  }
  return made;
}

}  // namespace isthmus::ros1
