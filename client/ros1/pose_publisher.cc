#include "client/ros1/pose_publisher.h"

#include <ros/console.h>

#include <utility>

#include "client/ros1/conversions.h"
#include "client/ros1/limits.h"

namespace isthmus::ros1 {

PosePublisher::PosePublisher(ros::NodeHandle& node, const FrameParameters& frames)
    : frames_(frames),
      odometry_(node.advertise<nav_msgs::Odometry>("odometry", kQueuedMessages)),
      listener_(buffer_),
      maker_(frames) {}

void PosePublisher::SetSensorFrame(const std::string& frame) {
  MutexLock lock(&mutex_);
  sensor_frame_ = frame;
}

SessionId PosePublisher::home() const {
  MutexLock lock(&mutex_);
  return maker_.home();
}

void PosePublisher::SetJoined(std::set<SessionId> sessions) {
  MutexLock lock(&mutex_);
  maker_.SetJoined(std::move(sessions));
}

std::optional<Pose> PosePublisher::LookUp(const std::string& parent, const std::string& child,
                                          const ros::Time& stamp, const char* advice) const {
  try {
    return ToPose(buffer_.lookupTransform(parent, child, stamp).transform);
  } catch (const tf2::TransformException& error) {
    ROS_WARN_THROTTLE(kComplaintPeriodS, "no transform from %s to %s, so no pose: %s; %s",
                      child.c_str(), parent.c_str(), error.what(), advice);
    return std::nullopt;
  }
}

PoseMaker::Tree PosePublisher::LookUpTree(const ScanAck& ack) {
  PoseMaker::Tree tree{sensor_frame_, std::nullopt, std::nullopt};
  const bool is_base = frames_.base.empty() || frames_.base == sensor_frame_;
  if (is_base) {
    tree.T_base_sensor = Pose();
  } else {
    tree.T_base_sensor =
        LookUp(frames_.base, sensor_frame_, ros::Time(0),
               "publish where the sensor is mounted (static_transform_publisher), or set "
               "~base_frame to the frame of the clouds");
  }
  if (!frames_.publish_odom_tf) {
    tree.T_odom_base =
        LookUp(frames_.odom, is_base ? sensor_frame_ : frames_.base, ToTime(ack.end_stamp_ns),
               "publish the robot's own odometry, or leave that to this node with "
               "~publish_odom_tf true");
  }
  return tree;
}

void PosePublisher::OnAck(const ScanAck& ack) {
  if (ack.outcome == ScanOutcome::kRejected) {
    ROS_WARN_THROTTLE(kComplaintPeriodS, "scan %lu was rejected: %s", ack.sequence,
                      ack.reason.c_str());
  }
  MutexLock lock(&mutex_);
  if (sensor_frame_.empty() || !ack.T_odom_sensor) return;
  const PoseMessages made = maker_.Make(ack, LookUpTree(ack));
  if (made.odometry) odometry_.publish(*made.odometry);
  if (!made.transforms.empty()) broadcaster_.sendTransform(made.transforms);
}

}  // namespace isthmus::ros1
