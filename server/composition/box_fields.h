// A box as bytes, for state_codec.h.
#pragma once

#include "core/cloud.h"
#include "core/state_codec.h"

namespace isthmus {

void Fields(IsRecord<Box> auto& box, auto& io) { io(box.min, box.max); }

}  // namespace isthmus
