// The points of a tile as browsers and caches get them, "PTS2" of docs/storage-format.md.
#pragma once

#include <absl/status/statusor.h>
#include <absl/strings/string_view.h>

#include <string>
#include <vector>

#include "core/cloud.h"

namespace isthmus::codec {

// Positions are rounded to 1/65535 of the points' extent along each axis, intensities to whole
// numbers from 0 to 255; robots above 255 become 255. At most 2^32 - 1 points; none is fine.
std::string WriteTilePoints(const std::vector<MapPoint>& points);

// The inverse, in the same order. DataLoss for bytes that are no such points.
absl::StatusOr<std::vector<MapPoint>> ReadTilePoints(absl::string_view bytes);

}  // namespace isthmus::codec
