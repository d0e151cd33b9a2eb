// Pose graphs as the placer makes them, one per component, with the origins of their parts.
#pragma once

#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include "absl/container/flat_hash_map.h"
#include "core/ids.h"
#include "server/pose_graph/problem.h"

namespace isthmus::placement {

// Sessions by short numbers, given once, so that keys are compared fast.
using SessionNumbers = std::map<SessionId, uint32_t>;

struct NodeKey {
  uint32_t session = 0;  // By SessionNumbers.
  uint32_t index = 0;    // The submap's.

  friend bool operator==(const NodeKey&, const NodeKey&) = default;
  template <typename H>
  friend H AbslHashValue(H h, const NodeKey& key) {
    return H::combine(std::move(h), key.session, key.index);
  }
};

enum class Source : uint8_t {
  kOdometry,
  kMatch,
  kNearest,  // A match without edges between submaps that are in the map.
  kLoop,
};

// The identity of an edge from call to call.
struct EdgeKey {
  Source source = Source::kOdometry;
  uint64_t loop = 0;  // LoopClosure::id; 0 for others.
  NodeKey a, b;
  uint32_t copy = 0;  // Tells edges apart that are alike in all of the above.

  friend bool operator==(const EdgeKey&, const EdgeKey&) = default;
  template <typename H>
  friend H AbslHashValue(H h, const EdgeKey& key) {
    return H::combine(std::move(h), key.source, key.loop, key.a, key.b, key.copy);
  }
};

struct EdgeOrigin {
  EdgeKey key;
  size_t record = 0;  // Index into Input::matches or Input::loops, by source, ...
  size_t edge = 0;    // ... and into its edges.
};

// The submaps of a session are nodes one after another.
struct GraphSession {
  size_t session = 0;  // Index into Input::sessions.
  uint32_t number = 0;
  int first_node = 0;
  int node_count = 0;
};

struct Graph {
  uint32_t component = 0;
  SessionId reference;
  std::vector<GraphSession> sessions;  // Ascending.
  std::vector<SubmapId> ids;           // By node, like `keys`.
  std::vector<NodeKey> keys;
  pose_graph::Problem problem;
  std::vector<EdgeOrigin> origins;  // In order of problem.edges.
  std::vector<size_t> anchors;      // Indices into Input::anchors, of the first problem.anchors.
  int gauge = 0;                    // The node that holds the map frame where no anchor does.
  // An anchor names one of its sessions, even of a submap that has left the map: then the frame is
  // the anchors'.
  bool anchored = false;

  size_t odometry_edges = 0;  // The first of problem.edges.
};

struct GraphSet {
  std::vector<Graph> graphs;  // In order of component.
  // An index of things: the number of the graph, and the place in it.
  absl::flat_hash_map<NodeKey, std::pair<size_t, int>> nodes;
  absl::flat_hash_map<EdgeKey, std::pair<size_t, size_t>> edges;
  absl::flat_hash_map<uint32_t, size_t> sessions;  // Graph of a session with nodes, by number.
};

}  // namespace isthmus::placement
