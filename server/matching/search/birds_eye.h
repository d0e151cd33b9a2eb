// Exhaustive search over yaw, x and y: a bird's-eye image of the wall points of one whole map is
// correlated (FFT) with the other's, and free space that one robot saw counts against walls of the
// other there. Needs gravity within about 10 degrees.
#pragma once

#include <stop_token>
#include <vector>

#include "core/map/match.h"
#include "core/map/submap.h"
#include "server/matching/registration/candidate.h"
#include "server/matching/search/wall_map.h"

namespace isthmus::matching {

struct BirdsEyeOptions {
  // 0: 0.25 m indoors, 0.5 m outdoors, told from the map itself; coarser where CellThatFits.
  double cell_m = 0;
  double yaw_step_rad = 0.0698;    // 4 degrees.
  double free_space_weight = 1.0;  // Weight of walls in seen free space against agreement.
  int candidates = 12;             // Returned at the most, after suppression of neighbours.
  std::stop_token stop = {};       // Ends the search early, with no candidates.
};

// Best first. Appends one entry to `stages`. Deterministic; thread safe (no shared state).
std::vector<Candidate> SearchBirdsEye(const WallMap& a, const WallMap& b,
                                      const BirdsEyeOptions& options,
                                      std::vector<StageTime>* stages);

// The scale for both together: outdoors if either of them is.
SceneScale PairScale(const WallMap& a, const WallMap& b);

}  // namespace isthmus::matching
