// A calibration of a Velodyne sensor, as velodyne_pointcloud of ROS writes it from the db.xml of
// the unit.
#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include <optional>
#include <string>

#include "client/readers/packets/velodyne/velodyne_model.h"

namespace isthmus::readers::velodyne {

// Reads YAML with num_lasers, distance_resolution (metres; absent: 2 mm) and lasers, a list of
// laser_id, rot_correction, vert_correction (radians), dist_correction, dist_correction_x,
// dist_correction_y, vert_offset_correction, horiz_offset_correction (metres), focal_distance,
// focal_slope, min_intensity, max_intensity; absent ones are 0, max_intensity 255. InvalidArgument,
// naming what is wrong, for anything else, numbers that are not finite, and where a laser is
// missing or given twice.
absl::StatusOr<Calibration> ParseCalibration(const std::string& yaml);

// InvalidArgument, saying what to give, for a model that has no calibration in its manual and was
// given none, and for a calibration of another number of lasers.
absl::Status CheckCalibration(Model model, const std::optional<Calibration>& calibration);

}  // namespace isthmus::readers::velodyne
