// Correlation of plans over all yaws and shifts, by FFT: where one may lie on the other.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <stop_token>
#include <vector>

#include "server/matching/index/session_plan.h"

namespace isthmus::matching {

// Where plan b may lie on plan a: a point p of b at R(yaw) p + shift.
struct PlanPlacement {
  double yaw = 0;
  Eigen::Vector2d shift = Eigen::Vector2d::Zero();
  double score = 0;

  Eigen::Vector2d Apply(const Eigen::Vector2d& p) const;
};

// The `count` best placements that are not each other's neighbours, best first, of plans in cells
// of one size. The score: walls on walls that face the same way, less blocking walls where the
// other plan is free. Empty if asked to stop. Deterministic; thread safe.
std::vector<PlanPlacement> CorrelatePlans(const SessionPlan& a, const SessionPlan& b, size_t count,
                                          const std::stop_token& stop = {});

}  // namespace isthmus::matching
