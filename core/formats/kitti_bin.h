// KITTI's velodyne files: float32 x y z intensity, nothing else.
#pragma once

#include <absl/status/statusor.h>

#include <string>

#include "core/point_payload.h"

namespace isthmus::formats {

// InvalidArgument when the size is not a multiple of 16 bytes. An empty file is an empty payload.
absl::StatusOr<PointPayload> ParseKittiBin(std::string bytes);

// NotFound, PermissionDenied or Unavailable when the file cannot be read; messages carry the path.
absl::StatusOr<PointPayload> ReadKittiBin(const std::string& path);

}  // namespace isthmus::formats
