// Refinement of a guess at T_a_b, coarse to fine: GICP on k-d tree neighbours from metres off, fast
// VGICP (Koide et al., ICRA 2021) last.
#pragma once

#include <memory>
#include <vector>

#include "core/map/match.h"
#include "core/map/submap.h"
#include "server/matching/registration/candidate.h"
#include "server/matching/registration/limits.h"
#include "server/matching/registration/surface.h"

namespace isthmus::matching {

struct RefineOptions {
  double voxel_m = kIndoorVoxelM;          // Thinning of both maps, at least; see max_points.
  double coarse_distance_m = kGuessGateM;  // Correspondence gate of the first GICP round.
  double vgicp_voxel_m = 1.0;  // Voxel of the VGICP target; at least 3 voxels of thinning.
  // A point of b overlaps a when it has a neighbour this near.
  double overlap_distance_m = kOnSurfaceM;
  int max_iterations = 60;  // Per round; from 7 m off GICP takes about 50.
  int max_points = 150000;  // Larger maps are thinned more coarsely, to about this many.
};

struct Refinement {
  Pose T_a_b;
  bool converged = false;
  double overlap = 0;     // Share of the points of the smaller map that lie on the other, [0, 1],
  int64_t inliers = 0;    // told from an even sample of them, of which these do.
  double residual_m = 0;  // RMS point-to-plane distance of the inliers.
  // The information of T_a_b, twist order [rho; phi], frame a: point-to-plane, the inliers taken as
  // independent. Its directions can be trusted (a corridor's length has none), its size flatters.
  Matrix6d information = Matrix6d::Zero();
};

// A map made ready for refinement once, to be used against many others and many guesses: thinned
// points with normals turned to where the sensor stood, covariances, k-d tree, Gaussian voxels.
class RefinableMap {
 public:
  // From a surface that was sampled with options.voxel_m.
  RefinableMap(std::vector<SurfacePoint> surface, const RefineOptions& options);
  ~RefinableMap();
  RefinableMap(RefinableMap&&) noexcept;

  struct Data;
  const Data& data() const { return *data_; }

 private:
  std::unique_ptr<Data> data_;
};

// The share of an even sample of b's points, [0, 1], that have a surface of a that faces alike
// within `reach_m`: a first look at a guess, some hundred times cheaper than refining it.
// Deterministic. Thread safe.
double CoarseOverlap(const RefinableMap& a, const RefinableMap& b, const Pose& T_a_b,
                     double reach_m);

// Right to a few centimetres where the guess lies within about 3 m and 5 degrees indoors, 5 m and 5
// degrees outdoors. Where maps do not meet, or are empty, `converged` is false and the pose is near
// the guess. Deterministic. Thread safe: both maps are only read. Starts no threads.
Refinement RefineAlignment(const RefinableMap& a, const RefinableMap& b, const Pose& guess_T_a_b,
                           const RefineOptions& options);

// Its two halves: from metres off to decimetres (GICP), and from there on (fast VGICP), which takes
// half of the time and can be spared where another guess has come to the same place.
Pose AlignCoarsely(const RefinableMap& a, const RefinableMap& b, const Pose& guess_T_a_b,
                   const RefineOptions& options);
Refinement AlignFinely(const RefinableMap& a, const RefinableMap& b, const Pose& coarse_T_a_b,
                       const RefineOptions& options);

}  // namespace isthmus::matching
