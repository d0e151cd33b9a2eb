// The topics and transforms that say where the robot is.
#pragma once

#include <ros/node_handle.h>
#include <tf2_ros/buffer.h>
#include <tf2_ros/transform_broadcaster.h>
#include <tf2_ros/transform_listener.h>

#include <set>
#include <string>

#include "client/ros1/pose_maker.h"
#include "core/concurrency/mutex.h"

namespace isthmus::ros1 {

// Thread safe. Publishes `odometry`.
class PosePublisher {
 public:
  PosePublisher(ros::NodeHandle& node, const FrameParameters& frames);

  // The clouds' frame; no pose is published before it is known.
  void SetSensorFrame(const std::string& frame);
  void OnAck(const ScanAck& ack);

  SessionId home() const;
  void SetJoined(std::set<SessionId> sessions);

 private:
  PoseMaker::Tree LookUpTree(const ScanAck& ack) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  std::optional<Pose> LookUp(const std::string& parent, const std::string& child,
                             const ros::Time& stamp, const char* advice) const;

  const FrameParameters frames_;
  const ros::Publisher odometry_;
  tf2_ros::Buffer buffer_;
  const tf2_ros::TransformListener listener_;
  tf2_ros::TransformBroadcaster broadcaster_;

  mutable Mutex mutex_;
  PoseMaker maker_ ABSL_GUARDED_BY(mutex_);
  std::string sensor_frame_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace isthmus::ros1
