// The sensor of a cloud, as far as the cloud tells.
#pragma once

#include <string>

#include "core/point_payload.h"

namespace isthmus::readers {

// The smallest usual model with as many rings as the rows or the ring field of a raw payload show:
// vlp16, hdl32, hdl64 or os1-128. Empty when neither tells.
std::string GuessSensor(const PointPayload& raw);

}  // namespace isthmus::readers
