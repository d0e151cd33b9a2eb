// From matches to placements: which sessions hang together, and by which matches.
//
// Section 3.3 of the paper: nodes are robots' maps, edges are matches weighted by confidence; the
// maximum spanning tree of each connected component gives every node its transform.
#pragma once

#include <optional>
#include <vector>

#include "core/ids.h"
#include "core/match.h"
#include "core/revision.h"

namespace isthmus::match_graph {

struct Node {
  SessionId session;
  double weight = 1;  // Size of the session's map (points); the heaviest becomes the reference.
};

struct Solution {
  std::vector<Placement> placements;  // In order of session; component 0 has the most nodes.
  // The matches that carry the placements: indices into the matches given, one per tree edge.
  std::vector<size_t> tree;
};

// Only accepted matches are edges: a rejected one never carries a placement, whatever it touches.
// Matches that name a session not among the nodes are left out. `previous` keeps the reference of a
// component as long as that session is in it, so that a map frame does not jump; where components
// join, the reference of the larger one stays. Deterministic.
Solution Solve(const std::vector<Node>& nodes, const std::vector<Match>& matches,
               const std::vector<Placement>& previous);

// T_a_b between two placed sessions' odom frames; nothing when they are in different components or
// unknown.
std::optional<Pose> FindTransform(const std::vector<Placement>& placements, const SessionId& a,
                                  const SessionId& b);

}  // namespace isthmus::match_graph
