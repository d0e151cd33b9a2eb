// Places of the match graph's sessions in a map, to draw them.
#pragma once

#include <Eigen/Core>
#include <map>
#include <vector>

#include "core/ids.h"
#include "core/records/map_graph.h"
#include "core/records/map_reading.h"

namespace isthmus::ros1 {

struct GraphNode {
  Eigen::Vector3d middle;  // Middle of its submaps' origins, map frame.
  // False: it is not joined with this map, and lies where the likeliest undecided match has it.
  bool is_placed = true;
};

// True if a match is neither accepted nor rejected, and says where the maps might meet.
bool IsUndecided(const Match& match);

// The sessions of one component, and those which an undecided match connects with one of them.
// The others have no place in its map and are left out.
std::map<SessionId, GraphNode> LayOut(const MatchGraph& graph,
                                      const std::vector<SubmapStatus>& submaps, uint32_t component);

}  // namespace isthmus::ros1
