// The error of a transform between two robots' maps.
#pragma once

#include <vector>

#include "core/map/match.h"
#include "lab/bench/merging/driven_robot.h"

namespace isthmus::bench {

// The error of the maps where both robots have been, or where they came nearest to each other, by
// the pairs of poses that are nearest in truth: half a drive's drift, which no transform can take
// back, is not in it.
struct MapError {
  double median_m = 0, median_deg = 0;
};

// The truth of two robots' maps. Immutable.
class PairTruth {
 public:
  PairTruth(const DrivenRobot& a, const DrivenRobot& b);

  // They drove on the same ground, so that there is a true transform.
  bool HasTransform() const { return same_ground_; }
  // False without poses; errors are those between the start frames then.
  bool known() const { return !near_.empty(); }

  MapError ErrorOf(const Pose& T_a_b) const;
  // The error of the transform between the start frames: contains the drift of both drives.
  MapError StartErrorOf(const Pose& T_a_b) const;
  // Transforms that make the maps fit at one place where both have been, each judged everywhere:
  // the worst of their errors, which is drift within the shared part and next to nothing without.
  const MapError& drift() const { return drift_; }
  // No farther off than this beyond drift().
  bool IsWithin(const Pose& T_a_b, double metres, double degrees) const;

 private:
  struct NearPoses {
    Pose T_a_b;  // Between the sensors, in truth.
    Pose T_odom_a, T_odom_b;
  };

  bool same_ground_ = false;
  std::vector<NearPoses> near_;
  Pose start_T_a_b_;
  MapError drift_;
};

// Medians over the edges between submaps: what a pose graph is given. Both robots must be on one
// ground. 0 without edges.
MapError ErrorOfEdges(const DrivenRobot& a, const DrivenRobot& b,
                      const std::vector<SubmapEdge>& edges);

}  // namespace isthmus::bench
