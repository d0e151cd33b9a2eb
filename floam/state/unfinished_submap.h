// A submap that grows, within a saved state.
#pragma once

#include "core/map/submap.h"
#include "core/state_codec.h"

namespace isthmus::floam {

// All but its id and robot, which the session gives. A submap that is read keeps Submap's promises,
// or the reader is not ok.
void WriteUnfinished(const Submap& submap, StateWriter& io);
void ReadUnfinished(StateReader& io, Submap& submap);

}  // namespace isthmus::floam
