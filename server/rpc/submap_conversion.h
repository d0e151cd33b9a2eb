// Conversion of an uploaded submap's message into the submap that the pipeline takes.
#pragma once

#include <absl/status/statusor.h>

#include "core/ids.h"
#include "core/submap.h"
#include "isthmus/v1/session_service.pb.h"

namespace isthmus::rpc {

// `header.cloud` holds its data. Points keep their order. InvalidArgument for a cloud that cannot
// be decoded, without points or x y z, coordinates or poses that are not finite, a point farther
// than 100 km from the submap's origin, and a `keyframe` that is not unsigned or names none.
absl::StatusOr<Submap> ToSubmap(v1::UploadSubmapHeader&& header, const RobotId& robot);

}  // namespace isthmus::rpc
