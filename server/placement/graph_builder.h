// The builder of pose graphs from records.
#pragma once

#include <map>
#include <utility>

#include "server/placement/graph.h"
#include "server/placement/placer.h"
#include "server/placement/retired_gaps.h"

namespace isthmus::placement {

// The submaps between which matches without edges were taken to hold, by session numbers. Kept from
// call to call, so that such an edge stays where it is while others come nearer.
struct NearestPair {
  Pose T_a_b;  // The match's.
  uint32_t a = 0, b = 0;
};
using NearestPairs = std::map<std::pair<uint32_t, uint32_t>, NearestPair>;

// Poses of the problems are not set, nor is anything held. What names submaps that are not in the
// map, or joins different components, and edges whose numbers are none, are passed over.
GraphSet BuildGraphs(const Input& input, const pose_graph::DriftModel& drift, const GapPoses& gaps,
                     SessionNumbers* numbers, NearestPairs* nearest);

// Accepted and finite.
bool IsAccepted(const Match& match);
// Said by a person.
bool IsByHand(const Match& match);

}  // namespace isthmus::placement
