// The shape of a session: how its submaps lie to each other by all that it knows itself, which is
// its odometry and its loops. What matches with other sessions say is left out, or a wrong one
// would bend the map by which it is judged.
#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "core/map/submap.h"
#include "server/pose_graph/information.h"
#include "server/pose_graph/problem.h"

namespace isthmus::matching {

// The pose graph of one session; nodes are positions in its list of submaps. Does not change.
struct SessionShape {
  // Steps from submap to submap, then the loops' edges that the rest does not contradict. Their
  // information is the session's knowledge of its own shape. Where loops show that the odometry
  // errs more than most, its steps say as much less.
  std::vector<pose_graph::Edge> edges;
  // Poses at which these agree best: the first submap lies as odometry has it (T_odom_submap).
  std::vector<Pose> best;
  std::vector<Pose> odometry;  // T_odom_submap as odometry has it.

  size_t steps() const { return best.empty() ? 0 : best.size() - 1; }
};

using SubmapList = std::vector<std::shared_ptr<const Submap>>;

// The submap as if odometry had it there; the very one given where it has.
std::shared_ptr<const Submap> LyingAt(const std::shared_ptr<const Submap>& submap,
                                      const Pose& T_odom_submap);

// The odometry's step from each submap to the next: the general drift and, where the submap comes
// with one, its own.
std::vector<pose_graph::Edge> OdometrySteps(const SubmapList& submaps,
                                            const pose_graph::DriftModel& drift = {});

// By how much the variance of the steps has to be larger for the loops behind them to be likely, at
// the poses of the problem: the sum of squared errors over the degrees of freedom (a posteriori
// variance factor), at least 1.
double DriftScale(const pose_graph::Problem& problem, const std::vector<pose_graph::Edge>& edges,
                  size_t steps);

// One shape laid on another of the same submaps, and the farthest that any of these is off then.
// Turns count by what they move at pose_graph::kLeverM.
struct ShapeFit {
  Pose T_to_from;
  double farthest_m = 0;
};
ShapeFit FitShape(const std::vector<Pose>& from, const std::vector<Pose>& to);

}  // namespace isthmus::matching
