// Trajectories as text, one `stamp tx ty tz qx qy qz qw` per line, as of the TUM RGB-D benchmark.
#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include <string>

#include "core/map/trajectory.h"

namespace isthmus::formats {

// Stamps in seconds keep every nanosecond, in writing (nine decimals) and in reading. Lines that
// start with #, empty lines and a byte-order mark are skipped. InvalidArgument, naming the line,
// for anything else that is not eight finite numbers with a quaternion that is not zero.
absl::StatusOr<Trajectory> ParseTum(const std::string& text);
std::string FormatTum(const Trajectory& trajectory);

// Errors as in file_io.h; messages carry the path.
absl::StatusOr<Trajectory> ReadTum(const std::string& path);
absl::Status WriteTum(const std::string& path, const Trajectory& trajectory);

}  // namespace isthmus::formats
