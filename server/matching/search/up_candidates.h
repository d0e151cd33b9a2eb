// Candidates for the upward direction in a map whose gravity is unknown, because the sensor was
// mounted at a slant or upside down, or carried by hand.
#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <vector>

#include "server/matching/registration/surface.h"

namespace isthmus::matching {

struct UpCandidate {
  // The smallest rotation that takes the hypothesised up to +z.
  Eigen::Quaterniond R_level_odom = Eigen::Quaterniond::Identity();
  double score = 0;     // [0, 1], comparable within one map.
  double opposite = 0;  // The score of the other end of the axis.
};

// At most `limit` candidates, best first, at least 10 degrees apart. An axis is likely to be the
// vertical when surfaces lie across it (floors, ceilings) or along it (walls), and when the map is
// thin along it; of its two ends that is up which more of the level surface faces, and faces in one
// plane: floors are even, ceilings differ from room to room. Each is refined as by EstimateLevel.
// The candidate within 10 degrees of odom's z is among them if its score is at least half of the
// best one's. A single candidate, identity with score 0, when there is hardly any surface.
//
// `sensors` (odom frame, may be empty): where the surface was seen from. It tells floors from
// ceilings where both are even: who drives is nearer to the floor. Costs some 10 ms, however large
// the map. Deterministic; thread safe.
std::vector<UpCandidate> FindUpCandidates(const std::vector<SurfacePoint>& surface, size_t limit,
                                          const std::vector<Eigen::Vector3f>& sensors = {});

// Can odom's z be believed to be up within `max_tilt_rad`: is a candidate there the best, or nearly
// so? `candidates` as FindUpCandidates gives them, with a limit of at least 2.
bool IsGravityKnown(const std::vector<UpCandidate>& candidates, double max_tilt_rad = 0.3);

}  // namespace isthmus::matching
