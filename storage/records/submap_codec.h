// A submap's keyframes and points as one compressed blob with a checksum. Its layout is specified
// in docs/storage-format.md, "Submap blob".
#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include <string>

#include "core/map/submap.h"

namespace isthmus::storage {

// Coordinates are rounded to multiples of `resolution_m`; all else is kept exactly. InvalidArgument
// for a resolution out of core/codec/quantized.h's range; the submap must have passed CheckBatch.
absl::StatusOr<std::string> EncodeSubmap(const Submap& submap, double resolution_m);

// Fills in keyframes and points. DataLoss, and `submap` unspecified, for anything EncodeSubmap did
// not make. Memory is bounded by the limits of a submap.
absl::Status DecodeSubmap(const std::string& blob, Submap& submap);

}  // namespace isthmus::storage
