// Poses that a pose graph begins from when its own are bad.
#pragma once

#include <optional>
#include <vector>

#include "server/pose_graph/problem.h"

namespace isthmus::pose_graph {

// Poses from edges alone, by two linear problems: rotations as matrices of 9 free entries that
// minimise the sum of k |R_b - R_a R_a_b|^2 and are then projected to SO(3); with these, positions
// that minimise the sum of w |t_b - t_a - R_a t_a_b|^2. k and w are the means of what the edge
// knows per axis, in g2o's convention. Martinec and Pajdla, "Robust rotation and translation
// estimation in multiview reconstruction", CVPR 2007; Carlone et al., "Initialization techniques
// for 3D SLAM", ICRA 2015, section III.C. No start is needed, so odometry may be as bad as it
// likes. Fixed nodes, and the lowest of each part of the graph without one, stay; anchors have no
// say. Empty where the linear problems cannot be solved.
std::optional<std::vector<Pose>> ChordalPoses(const Problem& problem);

// The chordal poses if they agree better with the edges than those of `problem`, else empty. The
// disagreement of edges in doubt counts by orders of magnitude above `doubt_chi2`.
std::optional<std::vector<Pose>> BetterStart(const Problem& problem, double doubt_chi2);

}  // namespace isthmus::pose_graph
