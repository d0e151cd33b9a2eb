// Clouds on disk as the submaps of robots.
#pragma once

#include <absl/status/statusor.h>

#include <string>
#include <vector>

#include "client/library/records.h"
#include "core/point_payload.h"

namespace isthmus::cli {

// Points whose x, y or z is not finite are left out; of what is left, no part holds more than
// `max_points`. The result is in the order of `raw`, fields as they were, height 1.
// InvalidArgument when there is no x, y, z or no point is left.
absl::StatusOr<std::vector<PointPayload>> SplitFinite(const PointPayload& raw, size_t max_points);

struct MergeInput {
  std::string file, robot;
  size_t points = 0;
  // Session and index are still to be set. The sensor is taken to have stood at the PCD's
  // viewpoint.
  std::vector<client::SubmapUpload> submaps;
};

// Reads every PCD. A robot is named after its file; equal names get a number. Messages carry the
// path.
absl::StatusOr<std::vector<MergeInput>> ReadMergeInputs(const std::vector<std::string>& files);

}  // namespace isthmus::cli
