// The compressed encoding of a point payload (PayloadEncoding::kQuantized). Its byte layout is
// specified in docs/storage-format.md, "Quantised payload".
#pragma once

#include <absl/status/statusor.h>

#include "core/point_payload.h"

namespace isthmus::codec {

// Range of Quantize's step. 0.001 to 0.005 suits LiDARs, whose noise is larger.
inline constexpr double kMinResolutionM = 1e-5;
inline constexpr double kMaxResolutionM = 0.1;

// The version of the layout (kQuantizedVersion); 0 for what is not quantised. Version 2 is that of
// scans whose points follow the rays of a spinning LiDAR; all others stay in version 1. Both give
// the same points back, bit by bit.
int QuantizedVersionOf(const PointPayload& quantized);

// Rounds x, y and z (where floating point) to multiples of `resolution_m`; every other field
// survives bit by bit. Order, layout and non-finite coordinates (as NaN) are kept; bytes of a
// record that no field covers come back as zero. InvalidArgument for a payload that is not raw, a
// bad layout (see CheckLayout), missing x y z, a step out of range, or a coordinate beyond 2^29
// steps from the origin (536 km at 1 mm). For readers that do not know all versions,
// `newest_version` is the last one that they do.
absl::StatusOr<PointPayload> Quantize(const PointPayload& raw, double resolution_m,
                                      int newest_version = kQuantizedVersion);

// The inverse; coordinates are within half a step of the original. Never allocates more than
// kMaxDecodedBytes. InvalidArgument for anything that Quantize did not make, damage included
// (the data carries a checksum).
absl::StatusOr<PointPayload> Dequantize(const PointPayload& quantized);

}  // namespace isthmus::codec
