// Parameters of the bridge, as docs/ros1.md tells them.
#pragma once

#include <absl/status/statusor.h>
#include <ros/node_handle.h>

#include <cstdint>
#include <string>

#include "client/readers/recording.h"

namespace isthmus::ros1 {

struct FrameParameters {
  std::string map = "map", odom = "odom";
  std::string base = "base_link";  // Empty: the frame of the clouds.
  bool publish_odom_tf = true;     // False: odom -> base is somebody else's.
  double tolerance_s = 0.2;        // By which map -> odom is dated ahead.
};

struct MapParameters {
  bool publish = true;
  double period_s = 5;
  double resolution_m = 0.2;
  int max_points = 2'000'000;
  double marker_size_m = 1;
};

struct Parameters {
  std::string server = "localhost:50051";
  std::string robot = {};  // Empty: nothing is pushed, only the map is shown.
  std::string points = "points";
  readers::ReadOptions read = {};  // Sensor, meaning of stamps, rate.
  double resolution_m = 0.002;
  std::string spool = {};
  double spool_gb = 8;
  double prefer_live_after_s = 0;
  bool finish = false;
  FrameParameters frames = {};
  MapParameters map = {};
};

// Parameters that are not set stay as they are above; an empty spool becomes a folder of the
// robot's name in ROS's own. InvalidArgument, naming it, for one that cannot be.
absl::StatusOr<Parameters> ReadParameters(const ros::NodeHandle& node);
// The checks alone, which need no ROS.
absl::Status Check(const Parameters& parameters);
// "times", "start" or "end".
absl::StatusOr<readers::StampMeaning> ParseStamps(const std::string& name);
// The robot's folder in ROS's own: $ROS_HOME, else .ros in the home folder.
std::string SpoolFolderOf(const std::string& robot);

}  // namespace isthmus::ros1
