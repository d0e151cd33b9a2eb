// Consensus among pairs of points most of which are wrong: Fischler and Bolles, "Random Sample
// Consensus", CACM 24, 1981, with the edge-length test of Buch et al., "Pose Estimation using Local
// Structure-Specific Shape and Appearance Context", ICRA 2013, before anything costly.
#pragma once

#include <vector>

#include "server/matching/paper/feature_chain_options.h"
#include "server/matching/paper/rigid_fit.h"

namespace isthmus::matching {

struct Consensus {
  Pose T_a_b;                // From the sample that found it.
  std::vector<int> inliers;  // Indices of pairs; at most one for every point of a.
};

// At most options.hypotheses distinct consensus sets, largest first. Pairs of one point of a must
// stand next to each other. Deterministic.
std::vector<Consensus> FindConsensus(const std::vector<PointPair>& pairs,
                                     const RansacOptions& options);

// The pairs that T_a_b brings within `distance_m`, one for every point of a.
std::vector<int> FindInliers(const std::vector<PointPair>& pairs, const Pose& T_a_b,
                             double distance_m);

// Mean of the pairs' points of b: where it makes sense to compare two poses.
Eigen::Vector3d CenterOfB(const std::vector<PointPair>& pairs);

// True when the two poses differ by at least options.distinct_m, measured at b's point `center_b`,
// or options.distinct_rad.
bool AreDistinct(const Pose& x, const Pose& y, const Eigen::Vector3d& center_b,
                 const RansacOptions& options);

}  // namespace isthmus::matching
