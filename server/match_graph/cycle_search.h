// Cycles of accepted matches, and the residual of going round each.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/map/match.h"
#include "server/match_graph/cycle_options.h"

namespace isthmus::match_graph {

// A session that matches hang on.
struct CycleNode {
  Eigen::Vector3d center;  // Center of its map, in odom.
  double extent_m = 0;     // Extent of its map.
};

// An accepted match of two different nodes, the only one of the two; a < b.
struct CycleEdge {
  uint32_t a = 0, b = 0;  // Indices of nodes.
  Pose T_a_b;
  double confidence = 0;
};

// The rest of going round a cycle, and its limits.
struct Residual {
  double m = 0, deg = 0;
  double max_m = 0, max_deg = 0;

  bool Agrees() const { return m <= max_m && deg <= max_deg; }
  // 1 at the limit of agreement.
  double Excess() const { return std::max(m / max_m, deg / max_deg); }
};

// One step of a way round: the node that is left, and where the next one lies in its odom frame.
struct Step {
  const CycleNode* from;
  Pose T_from_to;
};

// Goes round; the last step leads back to the first node.
Residual GoRound(const std::vector<Step>& steps, const CycleOptions& options);

struct Cycle : Residual {
  // Begins at the smallest node and goes on to the smaller of its two neighbours.
  std::vector<uint32_t> nodes;
  std::vector<uint32_t> edges;  // edges[i] joins nodes[i] and the node after it; indices.
};

// Finds cycles among edges that are switched off one by one. Keeps references to what it is given.
// Not thread safe.
class CycleSearch {
 public:
  CycleSearch(const std::vector<CycleNode>& nodes, const std::vector<CycleEdge>& edges,
              const CycleOptions& options);

  // Cycles of `active` edges: all triangles and squares, unless there are too many (CycleOptions),
  // and every cycle that an edge closes through the maximum spanning forest. Each once; an edge
  // that is in any cycle is in one of these.
  std::vector<Cycle> Find(const std::vector<bool>& active) const;

 private:
  struct Neighbour {
    uint32_t node, edge;
  };

  const Neighbour* FindNeighbour(uint32_t from, uint32_t to) const;
  bool AddTriangles();
  bool AddSquares();
  Cycle Measure(std::vector<uint32_t> nodes) const;
  void AddThroughForest(const std::vector<bool>& active, std::vector<Cycle>* cycles) const;

  const std::vector<CycleNode>& nodes_;
  const std::vector<CycleEdge>& edges_;
  const CycleOptions options_;
  std::vector<std::vector<Neighbour>> neighbours_;  // By node, in order.
  std::vector<Cycle> short_;                        // Cycles of all edges, active or not.
  size_t longest_short_ = 2;                        // All cycles up to this length are in short_.
};

}  // namespace isthmus::match_graph
