// Decoding of an uploaded submap into the one that the pipeline takes.
#pragma once

#include <absl/status/statusor.h>

#include "core/ids.h"
#include "core/map/submap.h"
#include "core/records/submap_upload.h"

namespace isthmus::rpc {

// Points keep their order. InvalidArgument for a cloud that cannot be decoded, without points or
// x y z, coordinates that are not finite, a point farther than 5 km from the submap's origin, a
// `keyframe` that is not unsigned or names none, and more than 65535 keyframes.
absl::StatusOr<Submap> DecodeSubmap(SubmapUpload upload, const RobotId& robot);

}  // namespace isthmus::rpc
