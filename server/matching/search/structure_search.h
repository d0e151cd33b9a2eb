// The search by what stands on the ground: trunks, poles, rails, pillars, furniture and walls
// alike, by the heights they fill, their images whitened so that what a world repeats everywhere
// says little.
#pragma once

#include <stop_token>
#include <vector>

#include "core/map/match.h"
#include "server/matching/registration/candidate.h"
#include "server/matching/search/birds_eye_image.h"
#include "server/matching/search/wall_map.h"

namespace isthmus::matching {

// Best first, source kStructure. Appends one entry to `stages`. With `stop` requested there may be
// none. Needs gravity within about 10 degrees. Deterministic; thread safe.
std::vector<Candidate> SearchStructure(const WallMap& a, const WallMap& b, std::stop_token stop,
                                       std::vector<StageTime>* stages);

// A map's cells for it: `weight` grows with the heights that are filled and how far they reach.
BirdsEyeCells MakeStructureCells(const WallMap& map, bool outdoors, double cell_m);

}  // namespace isthmus::matching
