// Candidates for the upward direction in a map whose gravity is unknown, because the sensor was
// mounted at a slant or upside down, or carried by hand.
#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "server/matching/registration/surface.h"

namespace isthmus::matching {

struct UpCandidate {
  // The smallest rotation that takes the hypothesised up to +z.
  Eigen::Quaterniond R_level_odom = Eigen::Quaterniond::Identity();
  double score = 0;     // [0, 1], comparable within one map.
  double opposite = 0;  // The score of the other end of the axis.
  double axis() const { return score + opposite; }
};

// Both ends of every axis that may be the vertical, best first, at least 10 degrees apart; odom's z
// is always tried. An axis is likely to be the vertical when surfaces lie across it (floors,
// ceilings) or along it (walls), when the map is thin along it, and when the sensor hardly moved
// along it; of its two ends that is up which more of the level surface faces, and faces in one
// plane: floors are even, ceilings differ from room to room. Each is refined as by EstimateLevel. A
// single candidate, identity with score 0, when there is hardly any surface.
//
// `sensors` (odom frame, may be empty): where the surface was seen from. It tells floors from
// ceilings where both are even: who drives is nearer to the floor. Costs some 10 ms, however large
// the map. Deterministic; thread safe.
std::vector<UpCandidate> FindUpCandidates(const std::vector<SurfacePoint>& surface,
                                          const std::vector<Eigen::Vector3f>& sensors = {});

// The one to believe. `candidates` as FindUpCandidates gives them. Most sensors are mounted upright
// or lean by less than 30 degrees: such an axis is taken where it is nearly as likely as the best,
// and of its ends the upper one, unless the lower is by far the likelier.
UpCandidate LikeliestUp(const std::vector<UpCandidate>& candidates);

}  // namespace isthmus::matching
