// Trajectories that other programs write: TUM, KITTI and g2o.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <string>
#include <vector>

#include "core/map/trajectory.h"

namespace isthmus::cloud_upload {

enum class PoseFormat : uint8_t {
  kTum,    // stamp tx ty tz qx qy qz qw, in seconds and metres.
  kKitti,  // The upper three rows of a 4x4 matrix, row by row: 12 numbers.
  kG2o,    // VERTEX_SE3:QUAT or VERTEX_SE2 lines, in order of their ids; others are not read.
};

struct PoseFile {
  PoseFormat format = PoseFormat::kTum;
  bool has_stamps = false;
  Trajectory poses;  // T_odom_sensor, in the order of the file; stamps are 0 where it has none.
  // The shift of all translations, as ShiftToOrigin (near_origin.h) says of the first.
  Eigen::Vector3d moved_by = Eigen::Vector3d::Zero();
};

// The first line tells the format: "VERTEX_...", "EDGE_..." and other words are g2o, 12 numbers
// KITTI, all else TUM. InvalidArgument, naming the line, for damaged text, for no pose at all, and
// for two poses of one instant that differ.
absl::StatusOr<PoseFile> ParsePoses(const std::string& text);

// Reads the file. A KITTI file with a times.txt beside it, of as many times (times_file.h), has its
// stamps. Errors as those of ReadFile (file_io.h); all messages carry the path.
absl::StatusOr<PoseFile> ReadPoses(const std::string& path);

// "TUM", "KITTI", "g2o".
const char* ToString(PoseFormat format);

}  // namespace isthmus::cloud_upload
