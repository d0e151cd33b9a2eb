// The numbers of a cloud that an upload takes.
#pragma once

#include <absl/status/statusor.h>

#include <vector>

#include "core/point_payload.h"

namespace isthmus::cloud_upload {

// The columns x, y, z and intensity; the last is empty where there is none. InvalidArgument for a
// cloud that is not raw or has no x, y, z.
absl::StatusOr<std::vector<std::vector<double>>> ReadColumns(const PointPayload& cloud);

}  // namespace isthmus::cloud_upload
