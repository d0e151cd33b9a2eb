// Messages that say where something is: fixes of GNSS receivers and static transforms.
#pragma once

#include <absl/status/statusor.h>
#include <absl/strings/string_view.h>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "client/readers/recording.h"

namespace isthmus::readers {

// The functions below return InvalidArgument, naming what is wrong, for what does not fit.

// sensor_msgs/NavSatFix. Empty for one that is no fix: its status is below 0, or a coordinate is
// not finite or outside of the Earth's. Sigmas are the roots of the covariance's diagonal, 0 where
// its type is 0 (not known) or it is not positive. One without a stamp is of when it was recorded.
absl::StatusOr<std::optional<GnssFix>> DecodeNavSatFix(absl::string_view encoding,
                                                       absl::string_view bytes, int64_t log_ns);

// tf2_msgs/TFMessage and tf/tfMessage. Rotations are normalised; InvalidArgument where one is zero
// or a number is not finite, naming the frames.
absl::StatusOr<std::vector<StaticTransform>> DecodeTransforms(absl::string_view encoding,
                                                              absl::string_view bytes);

// std_msgs/String.
absl::StatusOr<std::string> DecodeString(absl::string_view encoding, absl::string_view bytes);

}  // namespace isthmus::readers
