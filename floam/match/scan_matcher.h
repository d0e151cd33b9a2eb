// Matching of a scan's features to the local map.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <optional>
#include <vector>

#include "core/pose.h"
#include "floam/map/local_map.h"
#include "floam/match/degeneracy.h"
#include "floam/match/match_information.h"
#include "floam/match/match_sums.h"
#include "floam/scan/features.h"
#include "floam/scan/limits.h"

namespace isthmus::floam {

// The sensor's pose at one instant of a scan, and its motion during the scan.
struct ScanPose {
  Pose T_odom_sensor;                 // At `reference_s`.
  Vector6d twist = Vector6d::Zero();  // Per second, sensor frame, constant over the scan.
  double reference_s = 0;             // Relative to the END of the scan.

  // The pose at another instant of the scan.
  Pose At(double time_s) const { return T_odom_sensor * Exp((time_s - reference_s) * twist); }

  // For state_codec.h. Nothing that drives is faster.
  template <typename Self, typename Io>
  static void Fields(Self& self, Io& io) {
    io(self.T_odom_sensor, self.twist, self.reference_s);
    if constexpr (Io::kIsReading) {
      io.Expect(self.twist.norm() < 1e3 && std::abs(self.reference_s) < 10);
    }
  }
};

// Prior knowledge of the twist: with `since_previous_s` > 0 that it is about that of the motion
// from T_odom_previous to the pose sought; else that it is about `mean`.
struct TwistPrior {
  Pose T_odom_previous;
  double since_previous_s = 0;
  Vector6d mean = Vector6d::Zero();
  Vector6d sigma = Vector6d::Ones();  // m/s and rad/s.
};

struct MatchOptions {
  int max_iterations = 12;
  int pose_only_iterations = 3;         // Before the twist is estimated too, if it is.
  double point_noise_m = kRangeNoiseM;  // One sigma of a point's distance to a perfect plane.
  double pole_noise_m = 0.07;   // One sigma of a pole's middle: from each side another is seen.
  double kernel_start_m = 0.3;  // Scale of the Geman-McClure loss at first ...
  double kernel_m = 0.1;        // ... and, halved every iteration, at last.
  double gate_m = 1.0;          // Farther from its plane or line a point is no match.
  double stop_m = 3e-4;         // Steps smaller than both end the iteration.
  double stop_rad = 3e-5;
  // The deviation of the sensor from its expected pose within a scan, one sigma, m and rad: what
  // matches say no better than this is not observed.
  double free_sigma_m = 0.05;
  double free_sigma_rad = 0.02;
  int stride = 1;  // Uses every stride-th feature.
};

// The covariance that these free sigmas mean.
Matrix6d FreeMotion(const MatchOptions& options);

struct MatchResult {
  ScanPose pose;
  Matrix12d covariance = Matrix12d::Zero();  // For [pose motion; twist] as in MatchSums.
  Matrix6d information = Matrix6d::Zero();   // On the pose motion, by the matches alone.
  Degeneracy degeneracy;      // Directions that neither map nor scan before tells: see Join.
  Degeneracy map_degeneracy;  // Directions that the map does not tell.
  int features = 0;           // Tried.
  int used = 0;               // With a plane or line within the gate.
  // The share of the edges and poles tried that lie on lines and poles: the sum of their weights in
  // the robust loss over their number. Ground fits anywhere, these do not.
  double standing = 0;
  int standing_tried = 0;
  double agreement = 0;  // Mean weight in the robust loss of those used, [0, 1].
  int iterations = 0;
  // True if the scan before, too, tells well how the sensor moved: see Join.
  bool seconded = false;

  double Score() const { return agreement * used; }  // The best of several places has the most.
};

// Gauss-Newton over SE(3) on distances of surface points to planes and edge points to lines (F-LOAM
// eq. 2), under a Geman-McClure loss, with the paper's local weights. Not thread safe: holds
// scratch memory.
class ScanMatcher {
 public:
  // Minimises from `guess`, together with what is known of the pose. `poles` may be null.
  // Undistorts the features with the twist at hand in every iteration; the twist stays as it is
  // unless there is a `twist_prior` for it. Never fails: see MatchResult::used and agreement.
  MatchResult Match(const Features& features, const ScanPose& guess, const PosePrior& pose_prior,
                    const std::optional<TwistPrior>& twist_prior, const MatchOptions& options,
                    LocalMap* surfaces, LocalMap* edges, LocalMap* poles = nullptr);

 private:
  struct Pass;  // One iteration's sums.

  void AccumulateSurfaces(const Features& features, const MatchOptions& options, Pass* pass,
                          LocalMap* map);
  void AccumulateEdges(const Features& features, const MatchOptions& options, Pass* pass,
                       LocalMap* map);
  void AccumulatePoles(const Features& features, const MatchOptions& options, Pass* pass,
                       LocalMap* map);

  std::vector<MatchRow> rows_;
  std::vector<LocalMap::Found> found_surfaces_, found_edges_, found_poles_;  // One per feature.
};

}  // namespace isthmus::floam
