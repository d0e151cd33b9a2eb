// Points as a Draco point cloud (PayloadEncoding::kDraco), for points whose order says nothing, as
// those of the map: positions alone are smaller than in a quantised payload, and slower to write.
// The bytes are specified in docs/storage-format.md, "Draco payload".
#pragma once

#include <absl/status/statusor.h>

#include "core/point_payload.h"

namespace isthmus::codec {

// Rounds x, y and z to multiples of `resolution_m`, to the very values that Quantize rounds them
// to; every other field survives bit by bit. Points come in another order, each with its own
// fields; points that are equal stay as many. Resolutions as Quantize. InvalidArgument for a
// payload that is not raw, a bad layout (see CheckLayout), x y z that are missing or no float32,
// other fields that are not single values of four bytes or more than kMaxDracoFields, a coordinate
// that is not finite or beyond 2^29 steps from the origin.
absl::StatusOr<PointPayload> PackDraco(const PointPayload& raw, double resolution_m);

// Axes of the tree in which Draco sorts points: x y z and the other fields.
inline constexpr size_t kMaxDracoFields = 12;

// The inverse; coordinates are within half a step of the original. The bytes may be anybody's: they
// must begin as PackDraco writes them for these fields and this number of points, which bounds what
// is allocated. InvalidArgument for those that do not, or end early; other damage is not noticed,
// there being no checksum, and gives wrong values.
absl::StatusOr<PointPayload> UnpackDraco(const PointPayload& packed);

}  // namespace isthmus::codec
