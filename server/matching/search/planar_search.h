// The correlation of two maps seen from above over all yaws and shifts: where one could lie on the
// other.
#pragma once

#include <stop_token>
#include <vector>

#include "core/map/match.h"
#include "server/matching/registration/candidate.h"
#include "server/matching/search/birds_eye_image.h"
#include "server/matching/search/planar_pose.h"
#include "server/matching/search/wall_map.h"

namespace isthmus::matching {

struct PlanarSearchOptions {
  double yaw_step_rad = 0.0698;  // 4 degrees.
  bool whiten = false;           // See FftCorrelator.
  std::stop_token stop = {};     // Ends the search early.
};

// A few peaks of each yaw, in no order; `b` has the cell of the reference. Deterministic; thread
// safe.
std::vector<PlanarPose> SearchPlanar(const BirdsEyeImage& reference, const BirdsEyeCells& b,
                                     const PlanarSearchOptions& options);

// The guess that a planar pose is, at the height at which the maps' grounds meet.
Candidate ToCandidate(const WallMap& a, const WallMap& b, const PlanarPose& pose,
                      GuessSource source);

}  // namespace isthmus::matching
