// Poses and acknowledgements as messages of ROS.
#pragma once

#include <geometry_msgs/Transform.h>
#include <geometry_msgs/TransformStamped.h>
#include <nav_msgs/Odometry.h>
#include <ros/time.h>

#include <cstdint>
#include <string>

#include "core/pose.h"

namespace isthmus::ros1 {

// Nanoseconds since the Unix epoch; what ROS cannot say (before 1970, after 2106) becomes the
// nearest that it can.
ros::Time ToTime(int64_t stamp_ns);

geometry_msgs::Transform ToTransform(const Pose& T_parent_child);
// Normalised; the identity for a rotation of zero.
Pose ToPose(const geometry_msgs::Transform& T_parent_child);

geometry_msgs::TransformStamped MakeTransform(const ros::Time& stamp, const std::string& parent,
                                              const std::string& child, const Pose& T_parent_child);

// Into `message.pose`. `covariance` is that of a twist [rho; phi] in the frame of the sensor, by
// which the true pose is T_odom_sensor Exp(twist); the message's is of the base's pose, about the
// axes of odom, as REP 103 and nav_msgs/Odometry want it.
void SetPose(const Pose& T_odom_sensor, const Matrix6d& covariance, const Pose& T_base_sensor,
             nav_msgs::Odometry& message);
// The velocity between two poses, in the frame of the base, into `message.twist`.
void SetTwist(const Pose& T_odom_before, const Pose& T_odom_base, double seconds,
              nav_msgs::Odometry& message);

}  // namespace isthmus::ros1
