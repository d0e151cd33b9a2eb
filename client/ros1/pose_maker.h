// The server's answers to scans, as odometry and transforms.
#pragma once

#include <geometry_msgs/TransformStamped.h>
#include <nav_msgs/Odometry.h>

#include <optional>
#include <set>
#include <string>
#include <vector>

#include "client/ros1/odom_frames.h"
#include "client/ros1/parameters.h"
#include "core/scan_upload.h"

namespace isthmus::ros1 {

struct PoseMessages {
  // In the odom frame; where odom -> base is somebody else's in the map frame, and then only where
  // the robot's place in it is known.
  std::optional<nav_msgs::Odometry> odometry;
  std::vector<geometry_msgs::TransformStamped> transforms;
};

// The frames of REP 105 (www.ros.org/reps/rep-0105.html). `map` is that of the map in which the
// home session lies, the first of this run. A lone session's map is its own odom frame, so until
// home is placed map -> odom is the identity. Of later segments and sessions there is no
// map -> odom before the server has joined them with home: a robot that asks for its place then
// learns that it is not known, instead of being put where it is not.
//
// Not thread safe.
class PoseMaker {
 public:
  explicit PoseMaker(FrameParameters frames) : frames_(std::move(frames)), odoms_(frames_.odom) {}

  // The tf tree's poses: T_base_sensor, and T_odom_base at that time if others publish it. Empty if
  // it does not say.
  struct Tree {
    std::string sensor_frame;
    std::optional<Pose> T_base_sensor;
    std::optional<Pose> T_odom_base;
  };
  // Messages for one answer. Nothing for a scan that has no pose, and for one that is not newer
  // than the last: of two sessions that are sent beside each other the newer one counts.
  PoseMessages Make(const ScanAck& ack, const Tree& tree);

  // The sessions of the component in which home lies.
  void SetJoined(std::set<SessionId> sessions) { joined_ = std::move(sessions); }
  // Empty before the first pose.
  const SessionId& home() const { return home_; }

 private:
  std::optional<Pose> PlaceOdom(const ScanAck& ack) const;
  nav_msgs::Odometry MakeOdometry(const ScanAck& ack, const Tree& tree, const Pose& T_frame_odom);

  const FrameParameters frames_;
  OdomFrames odoms_;
  SessionId home_;
  std::set<SessionId> joined_;
  int64_t last_ns_ = 0;
  SessionId last_segment_;
  Pose T_odom_last_;  // The base's.
};

}  // namespace isthmus::ros1
