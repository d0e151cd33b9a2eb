// The choice between rays and differences from point to point for a scan's coordinates.
#pragma once

#include <optional>

#include "core/codec/ray_model.h"

namespace isthmus::codec {

// The model by which the points take less than by delta codes (delta_code.h), as a stretch of them
// tells; none where there is none.
std::optional<RayModel> ChooseRays(const RayPoints& points);

}  // namespace isthmus::codec
