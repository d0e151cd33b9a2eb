// Gaps that retired submaps leave in a session. Odometry says little across them, as it has drifted
// for as long as the robot went on; where the ends were placed says more.
#pragma once

#include <cstdint>
#include <map>
#include <tuple>
#include <vector>

#include "core/map/revision.h"
#include "server/placement/placer.h"

namespace isthmus::placement {

// T_a_b of submaps a and b of a session between which all were retired, as they were placed when
// they became neighbours.
using GapPoses = std::map<std::tuple<SessionId, uint32_t, uint32_t>, Pose>;

// Takes in new gaps, by `previous` or, where their ends were not placed, by odometry, and forgets
// those that are gone.
void UpdateGaps(const std::vector<Placement>& previous, const Input& input, GapPoses* gaps);

// From one node of the session to the next: odometry, or what is kept of a gap.
Pose StepBetween(const SessionId& session, const Node& a, const Node& b, const GapPoses& gaps);

}  // namespace isthmus::placement
