// Initial poses for the search.
#pragma once

#include <vector>

#include "server/placement/graph.h"
#include "server/placement/placer.h"

namespace isthmus::placement {

// As readers see them: each submap where `previous` has it; others follow their neighbours in the
// session by odometry. Sessions that lie in another map frame, or in none yet, are moved to this
// one as they are shaped, by the edges of the surest match that leads there.
void ContinuePoses(const Input& input, const std::vector<Placement>& previous, Graph* graph);

// As the spanning tree and the odometry have it. With `same_frame` the gauge node keeps the pose
// that it has in `previous`, if it is in this map frame there, and the rest goes with it.
void BeginPosesAnew(const Input& input, const std::vector<Placement>& previous, bool same_frame,
                    Graph* graph);

// The pose that the tree gives a node of the graph when the gauge node lies as it does now.
Pose TreePose(const Input& input, const Graph& graph, int node);

// The placement of a session and the pose of a submap; null if there is none.
const Placement* FindPlacement(const std::vector<Placement>& placements, const SessionId& session);
const Pose* FindPose(const Placement& placement, uint32_t index);

}  // namespace isthmus::placement
