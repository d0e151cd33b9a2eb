// KITTI's velodyne files, float32 x y z intensity and nothing else, and those that are alike.
#pragma once

#include <absl/status/statusor.h>

#include <string>

#include "core/point_payload.h"

namespace isthmus::formats {

// The layout is told by the values, as no header tells it: the first of these of which they are
// plausible.
//   x y z intensity              KITTI
//   x y z intensity ring         nuScenes
//   x y z intensity ring time    (or another sixth column, which is left unnamed)
//   all x, all y, all z, all intensities
// Intensities are not negative, rings whole numbers. InvalidArgument, saying what to do, for bytes
// that fit none of them. An empty file is an empty payload.
absl::StatusOr<PointPayload> ParseKittiBin(std::string bytes);

// NotFound, PermissionDenied or Unavailable when the file cannot be read; messages carry the path.
absl::StatusOr<PointPayload> ReadKittiBin(const std::string& path);

}  // namespace isthmus::formats
