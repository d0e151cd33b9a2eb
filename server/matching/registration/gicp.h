// Generalized ICP: Segal, Haehnel, Thrun, "Generalized-ICP", RSS 2009. Every point stands for a
// small disc on the surface it was sampled from; pairs are nearest neighbours.
#pragma once

#include <vector>

#include "server/matching/registration/kd_tree.h"
#include "server/matching/registration/pose_problem.h"
#include "server/matching/registration/surface.h"

namespace isthmus::matching {

// Covariance of a surface point along and across its surface, in square metres up to a common
// factor: 1 along, `across` from roughness, at least 1e-3 (Segal et al., section III.B).
float AcrossCovariance(const SurfacePoint& point);

// Inverse of C_a + C_b for two discs of normals n_a and n_b in one frame.
Eigen::Matrix3d DiscInformation(const Eigen::Vector3d& n_a, double across_a,
                                const Eigen::Vector3d& n_b, double across_b);

// The result of a round of matching: pairs with robust weights, and how far off they still are.
struct PairSet {
  std::vector<Correspondence> pairs;
  double median_normal_distance_m = 0;  // Over the pairs, along the normals of a.
};

// For every b[i], i in `sample`, its nearest neighbour in a within `gate_m` whose normal is within
// 60 degrees. Weights fall off after Geman and McClure, scaled by the pairs' own median error.
void FindGicpPairs(const std::vector<SurfacePoint>& a, const KdTree& tree_a,
                   const std::vector<SurfacePoint>& b, const std::vector<int>& sample,
                   const Pose& T_a_b, double gate_m, PairSet* result);

// The gate follows the error that is left: a few times the median distance, never growing, never
// below what thinning to `voxel_m` alone makes of neighbours. Of a's voxel, from LeastGate up.
double LeastGate(double voxel_m);
double NextGate(double gate_m, double median_normal_distance_m, double voxel_m);

// Multiplies every weight by (s / (s + e))^2, e = d^T W d being the pair's squared error under
// T_a_b and s the larger of `floor` and three medians of e. A redescending kernel: what one map
// does not show at all has no say.
void ApplyRobustWeights(const Pose& T_a_b, double floor, std::vector<Correspondence>* pairs);

}  // namespace isthmus::matching
