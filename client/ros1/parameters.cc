#include "client/ros1/parameters.h"

#include <absl/strings/str_cat.h>

#include <cstdlib>

namespace isthmus::ros1 {
namespace {

// A parameter of another type is refused: it would keep its default in silence.
class Reader {
 public:
  explicit Reader(const ros::NodeHandle& node) : node_(node) {}

  template <typename T>
  void Read(const char* name, T& value) {
    if (node_.hasParam(name) && !node_.getParam(name, value) && status_.ok()) {
      status_ = absl::InvalidArgumentError(
          absl::StrCat("~", name, " is of another type than docs/ros1.md says; set it again"));
    }
  }
  const absl::Status& status() const { return status_; }

 private:
  const ros::NodeHandle& node_;
  absl::Status status_;
};

absl::Status CheckNumber(const char* name, double value, double least, double most) {
  if (value >= least && value <= most) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrCat("~", name, " is ", value, "; set it to between ", least, " and ", most));
}

}  // namespace

absl::StatusOr<readers::StampMeaning> ParseStamps(const std::string& name) {
  if (name == "times") return readers::StampMeaning::kByTimes;
  if (name == "start") return readers::StampMeaning::kStart;
  if (name == "end") return readers::StampMeaning::kEnd;
  return absl::InvalidArgumentError(
      absl::StrCat("~stamps is '", name, "'; set it to times, start or end"));
}

std::string SpoolFolderOf(const std::string& robot) {
  const char* const ros_home = std::getenv("ROS_HOME");
  const char* const home = std::getenv("HOME");
  const std::string base = ros_home != nullptr ? ros_home
                           : home != nullptr   ? absl::StrCat(home, "/.ros")
                                               : ".ros";
  return absl::StrCat(base, "/isthmus/", robot);
}

absl::Status Check(const Parameters& parameters) {
  for (const absl::Status& status :
       {CheckNumber("rate", parameters.read.rate_hz, 0.1, 1000),
        CheckNumber("resolution", parameters.resolution_m, 0, 0.1),
        CheckNumber("spool_gb", parameters.spool_gb, 0.1, 1e6),
        CheckNumber("prefer_live_after", parameters.prefer_live_after_s, 0, 1e9),
        CheckNumber("tf_tolerance", parameters.frames.tolerance_s, 0, 10),
        CheckNumber("map_period", parameters.map.period_s, 0.1, 1e6),
        CheckNumber("map_resolution", parameters.map.resolution_m, 0.01, 100),
        CheckNumber("map_max_points", parameters.map.max_points, 1000, 1e8),
        CheckNumber("marker_size", parameters.map.marker_size_m, 0.01, 1000)}) {
    if (!status.ok()) return status;
  }
  if (parameters.robot.find('/') != std::string::npos) {
    return absl::InvalidArgumentError("~robot must not hold a slash: it names a folder, too");
  }
  const FrameParameters& frames = parameters.frames;
  if (frames.map.empty() || frames.odom.empty() || frames.map == frames.odom ||
      frames.odom == frames.base || frames.map == frames.base) {
    return absl::InvalidArgumentError(
        "~map_frame, ~odom_frame and ~base_frame must be three names, the first two not empty");
  }
  return absl::OkStatus();
}

absl::StatusOr<Parameters> ReadParameters(const ros::NodeHandle& node) {
  Parameters parameters;
  std::string stamps = "times";
  Reader reader(node);
  reader.Read("server", parameters.server);
  reader.Read("robot", parameters.robot);
  reader.Read("points", parameters.points);
  reader.Read("sensor", parameters.read.sensor);
  reader.Read("stamps", stamps);
  reader.Read("rate", parameters.read.rate_hz);
  reader.Read("resolution", parameters.resolution_m);
  reader.Read("spool", parameters.spool);
  reader.Read("spool_gb", parameters.spool_gb);
  reader.Read("prefer_live_after", parameters.prefer_live_after_s);
  reader.Read("finish", parameters.finish);
  reader.Read("map_frame", parameters.frames.map);
  reader.Read("odom_frame", parameters.frames.odom);
  reader.Read("base_frame", parameters.frames.base);
  reader.Read("publish_odom_tf", parameters.frames.publish_odom_tf);
  reader.Read("tf_tolerance", parameters.frames.tolerance_s);
  reader.Read("publish_map", parameters.map.publish);
  reader.Read("map_period", parameters.map.period_s);
  reader.Read("map_resolution", parameters.map.resolution_m);
  reader.Read("map_max_points", parameters.map.max_points);
  reader.Read("marker_size", parameters.map.marker_size_m);
  if (!reader.status().ok()) return reader.status();
  const auto meaning = ParseStamps(stamps);
  if (!meaning.ok()) return meaning.status();
  parameters.read.stamps = *meaning;
  if (parameters.spool.empty()) parameters.spool = SpoolFolderOf(parameters.robot);
  if (absl::Status status = Check(parameters); !status.ok()) return status;
  return parameters;
}

}  // namespace isthmus::ros1
