// The match graph: which sessions hang together, by which matches, and where that places them.
//
// Section 3.3 of the paper: nodes are robots' maps, edges are matches weighted by confidence; the
// maximum spanning tree of each connected component gives every node its transform. The tree is
// Kruskal's (1956), on negated confidences.
//
// Two things differ from the paper. It keeps the largest component only: here each component has a
// map of its own, so that a robot nobody has met yet is served too. And the reference is kept
// across solutions instead of being chosen anew, so that readers' coordinates stay good.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include "core/ids.h"
#include "core/map/match.h"
#include "core/map/revision.h"

namespace isthmus::match_graph {

struct Node {
  SessionId session;
  double weight = 1;  // Size of the session's map (points); the heaviest becomes the reference.
  // The position of its map in odom, and its extent: the diagonal of the box of its submaps'
  // origins. For CheckCycles and SettleGroups.
  Eigen::Vector3d center = Eigen::Vector3d::Zero();
  double extent_m = 0;
  std::map<uint32_t, Eigen::Vector3d> submaps = {};  // Origins by index, in odom.
};

// True if a match may be an edge: accepted, and its confidence and transform finite.
bool MayCarry(const Match& match);

struct Solution {
  std::vector<Placement> placements;  // In order of session; component 0 has the most nodes.
  // The matches that carry the placements, the most confident first: indices into the matches
  // given, one per tree edge.
  std::vector<size_t> tree;
};

// Only accepted matches are edges: a rejected one never carries a placement, whatever it touches.
// Matches that name a session not among the nodes, the same session twice, or a confidence or
// transform that is not finite are left out.
//
// Components are numbered by how many nodes they have, the largest 0; equals keep the order that
// `previous` has, so that one that comes later takes no number from them. `previous` also keeps the
// reference of a component as long as that session is in it, so that a map frame does not jump;
// where components join, the reference of the larger one stays (the heavier reference of equals). A
// component that lost its reference takes its heaviest node.
//
// Deterministic: the order of nodes and matches does not matter. Thread safe (no shared state).
Solution Solve(const std::vector<Node>& nodes, const std::vector<Match>& matches,
               const std::vector<Placement>& previous);

// T_a_b between two placed sessions' odom frames; nothing when they are in different components or
// unknown.
std::optional<Pose> FindTransform(const std::vector<Placement>& placements, const SessionId& a,
                                  const SessionId& b);

}  // namespace isthmus::match_graph
