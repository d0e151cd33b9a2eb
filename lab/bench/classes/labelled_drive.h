// Simulated drives whose points are known to be of ground, walls and so on.
#pragma once

#include <absl/status/statusor.h>

#include <Eigen/Core>
#include <string>
#include <vector>

#include "core/map/point_class.h"
#include "lab/bench/merging/drive_options.h"

namespace isthmus::bench {

// A submap thinned as composition thins it, submap frame.
struct LabelledSubmap {
  std::vector<Eigen::Vector3f> points;
  std::vector<PointClass> truth;  // The class of most measured points of the voxel; one each.
  std::vector<Eigen::Vector3f> sensors;  // The keyframes' places.
  Eigen::Vector3f up;                    // The odom frame's z.
};

// All robots' of a world. Errors as MapTeam.
absl::StatusOr<std::vector<LabelledSubmap>> LabelledDrives(DriveOptions options);

}  // namespace isthmus::bench
