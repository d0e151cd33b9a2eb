// Clouds on disk as the submaps of robots.
#pragma once

#include <absl/status/statusor.h>

#include <Eigen/Core>
#include <set>
#include <string>
#include <vector>

#include "core/cloud.h"
#include "core/point_payload.h"
#include "core/records/submap_upload.h"

namespace isthmus::cli {

// The points with finite coordinates, in order, moved near the origin as ShiftToOrigin
// (near_origin.h) says of their middle; `moved_by` is what was added. InvalidArgument when there is
// no x, y, z or no such point, or one is farther than a submap reaches, which is named by its index
// in `payload`. `payload` must be raw.
absl::StatusOr<Cloud> FinitePoints(const PointPayload& payload,
                                   Eigen::Vector3d* moved_by = nullptr);

// "a.tum" for "a.pcd".
std::string TrajectoryBeside(const std::string& file);

// The file of a drive's poses in the merged map.
struct TrajectoryFile {
  std::string file;  // Empty: none was written.
  size_t poses = 0;
  std::vector<uint32_t> left_out;  // Segments of the drive that lie in other maps.
};

struct MergeInput {
  std::string file, robot;
  size_t points = 0;
  size_t viewpoints = 0;  // Places from which the sensor is known to have looked; 0: bare.
  // The shift that was added to the file's coordinates, m, as they were far from their origin.
  Eigen::Vector3d moved_by = Eigen::Vector3d::Zero();
  bool is_drive = false;  // It came as scans: see drives.h.
  TrajectoryFile trajectory;
  std::vector<std::string> notes;  // Sentences for the user: what was done to what the file holds.
  // Session and index are still to be set.
  std::vector<SubmapUpload> submaps;
};

// A robot's name for a file or topic, which joins `taken`: equal names get a number.
std::string UniqueRobotName(const std::string& path, std::set<std::string>& taken);

// Reads every cloud (cloud_file.h). A robot is named after its file, as UniqueRobotName does it.
// Where the sensor stood is told by a trajectory beside it, in the same frame (A.tum for A.pcd),
// else by the PCD's VIEWPOINT if that is not the identity that every program writes; else it is
// guessed, so that alignments can be searched for, but not verified. Messages carry the path.
// InvalidArgument, too, for clouds with too few points to match, and where the sensor is told to
// have stood so far off that it saw no point.
absl::StatusOr<std::vector<MergeInput>> ReadMergeInputs(const std::vector<std::string>& files,
                                                        std::set<std::string>& names);

}  // namespace isthmus::cli
