// Version 2 of the quantised payload, for scans of spinning LiDARs: coordinates as distances along
// the rays of a model. Its byte layout is specified in docs/storage-format.md, "Rays".
#pragma once

#include <absl/status/status.h>

#include <optional>
#include <string>
#include <vector>

#include "core/codec/quantized_columns.h"
#include "core/point_payload.h"

namespace isthmus::codec {

// Everything behind the header. Empty where the points follow no rays, or version 1 is as small:
// rings or times are missing, or the directions are not theirs. `raw` and the step were checked.
std::optional<std::string> PackRays(const PointPayload& raw, const std::vector<Column>& columns,
                                    double resolution_m);

// The inverse: fills the data of `raw`, which has the layout. The header was checked.
// InvalidArgument for what PackRays did not make.
absl::Status UnpackRays(const PointPayload& quantized, const std::vector<Column>& columns,
                        PointPayload& raw);

}  // namespace isthmus::codec
