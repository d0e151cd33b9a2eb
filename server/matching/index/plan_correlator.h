// Correlation of plans over all yaws and shifts, by FFT: where one may lie on the other.
#pragma once

#include <stop_token>
#include <vector>

#include "server/matching/index/session_plan.h"
#include "server/matching/search/planar_pose.h"

namespace isthmus::matching {

// Where plan b may lie on plan a: the `count` best placements that are not each other's neighbours,
// best first, of plans in cells of one size. The score: walls on walls that face the same way, less
// blocking walls where the other plan is free. Empty if asked to stop. Deterministic; thread safe.
std::vector<PlanarPose> CorrelatePlans(const SessionPlan& a, const SessionPlan& b, size_t count,
                                       const std::stop_token& stop = {});

}  // namespace isthmus::matching
