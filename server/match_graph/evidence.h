// Evidence on pairs of sessions that none of them decides alone.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <map>
#include <vector>

#include "core/ids.h"
#include "core/map/match.h"
#include "server/match_graph/cycle_search.h"
#include "server/match_graph/group_options.h"
#include "server/match_graph/match_graph.h"

namespace isthmus::match_graph {

// One way in which the maps of an open pair could lie on each other.
struct Hypothesis {
  uint32_t a = 0, b = 0;  // Indices of nodes, a < b.
  Pose T_a_b;
  double log_odds = 0;  // Odds of being right, against none of its pair's being so.
  Match* match = nullptr;
  size_t rival = 0;  // Number of the match's rival, counted from 1; 0: its own transform.
  // The beginnings of the submaps that it rests on, in the odom frames of a and b; none: not known.
  std::vector<Eigen::Vector3d> ground_a, ground_b;
};

// The hypotheses on an open pair.
struct OpenPair {
  uint32_t a = 0, b = 0;               // Indices of nodes, a < b.
  std::vector<Hypothesis> hypotheses;  // The most probable first.
  std::vector<Hypothesis> contradicted;
};

// Sessions, in an order of their own, and the evidence on pairs of them.
struct Evidence {
  std::vector<SessionId> sessions;  // Sorted.
  std::vector<CycleNode> nodes;
  std::vector<Hypothesis> joints;  // Accepted, the most confident first.
  std::vector<OpenPair> pairs;     // In order.
};

// If a pair is named twice, the more confident match counts. Keeps pointers to the matches.
Evidence CollectEvidence(const std::vector<Node>& nodes, const GroupOptions& options,
                         std::vector<Match>* matches);

// True if two sets of places, in one frame, are about the same. Unknown places may be.
bool AreSameGround(const std::vector<Eigen::Vector3d>& p, const std::vector<Eigen::Vector3d>& q,
                   const CycleOptions& options);

// The beginnings of the submaps that the edges name on a's side, or else b's; in odom.
std::vector<Eigen::Vector3d> GroundOf(const Node& node, const std::vector<SubmapEdge>& edges,
                                      bool of_a);

}  // namespace isthmus::match_graph
