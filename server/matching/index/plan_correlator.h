// Correlation of plans over all yaws and shifts, by FFT: where one may lie on the other.
#pragma once

#include <cstddef>
#include <map>
#include <memory>
#include <stop_token>
#include <utility>
#include <vector>

#include "server/matching/index/session_plan.h"
#include "server/matching/search/planar_pose.h"

namespace isthmus::matching {

// A plan that is laid on others. The work that does not depend on these is done once for all that
// are about as large, and kept: some 20 MB, about kMaxTurnedBytes at most. Not thread safe.
class PlanCorrelator {
 public:
  explicit PlanCorrelator(std::shared_ptr<const SessionPlan> moved);
  ~PlanCorrelator();

  // The placements at which the plan may lie on plan a: the `count` best that are not each other's
  // neighbours, best first, both in cells of so many metres. The score: walls on walls that face
  // the same way, less blocking walls where the other plan is free. Empty if asked to stop.
  // Deterministic.
  std::vector<PlanarPose> Correlate(const SessionPlan& a, float cell_m, size_t count,
                                    const std::stop_token& stop = {});

 private:
  class Turned;

  Turned& TurnedFor(float cell_m, int size);

  const std::shared_ptr<const SessionPlan> moved_;
  std::map<float, SessionPlan> coarse_;                              // By cell.
  std::map<std::pair<float, int>, std::unique_ptr<Turned>> turned_;  // By cell and size.
  size_t bytes_ = 0;                                                 // Size of `turned_`.
};

}  // namespace isthmus::matching
