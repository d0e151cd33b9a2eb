#include "server/match_graph/cycle_search.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "core/union_find.h"

namespace isthmus::match_graph {
namespace {

// The most confident first; ties by the edges' order, which is that of the sessions.
std::vector<uint32_t> ByConfidence(const std::vector<CycleEdge>& edges,
                                   const std::vector<bool>& active) {
  std::vector<uint32_t> order;
  for (uint32_t e = 0; e < edges.size(); ++e) {
    if (active[e]) order.push_back(e);
  }
  std::stable_sort(order.begin(), order.end(), [&](uint32_t l, uint32_t r) {
    return edges[l].confidence > edges[r].confidence;
  });
  return order;
}

// The forest hung up at one node of each tree.
struct HungForest {
  static constexpr uint32_t kUnreached = ~uint32_t{0};
  std::vector<uint32_t> parent, depth;

  HungForest(size_t node_count, const std::vector<std::vector<uint32_t>>& neighbours)
      : parent(node_count, kUnreached), depth(node_count, kUnreached) {
    for (uint32_t root = 0; root < node_count; ++root) {
      if (depth[root] != kUnreached) continue;
      depth[root] = 0;
      std::vector<uint32_t> open = {root};
      while (!open.empty()) {
        const uint32_t i = open.back();
        open.pop_back();
        for (const uint32_t j : neighbours[i]) {
          if (depth[j] != kUnreached) continue;
          parent[j] = i;
          depth[j] = depth[i] + 1;
          open.push_back(j);
        }
      }
    }
  }

  // The nodes from a to b, both in one tree.
  std::vector<uint32_t> Path(uint32_t a, uint32_t b) const {
    std::vector<uint32_t> up = {a}, down = {b};
    while (a != b) {
      if (depth[a] >= depth[b]) {
        up.push_back(a = parent[a]);
      } else {
        down.push_back(b = parent[b]);
      }
    }
    down.pop_back();  // The node where they meet is at the end of both.
    up.insert(up.end(), down.rbegin(), down.rend());
    return up;
  }
};

// So that one cycle is measured in one way, wherever it was entered.
std::vector<uint32_t> Canonical(std::vector<uint32_t> nodes) {
  std::rotate(nodes.begin(), std::min_element(nodes.begin(), nodes.end()), nodes.end());
  if (nodes[1] > nodes.back()) std::reverse(nodes.begin() + 1, nodes.end());
  return nodes;
}

}  // namespace

Residual GoRound(const std::vector<Step>& steps, const CycleOptions& options) {
  const auto length = static_cast<double>(steps.size());
  Pose round;  // From the frame of the node at hand to that of the first.
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  double drift_squared = 0;
  for (const Step& step : steps) {
    middle += round * step.from->center / length;
    drift_squared += std::pow(options.drift * step.from->extent_m, 2);
    round = round * step.T_from_to;
  }
  Residual left;
  // In the middle of the maps, where the arm on which a small turn acts is shortest.
  left.m = (round * middle - middle).norm();
  left.deg = RotationAngle(round) * 180 / std::numbers::pi;
  left.max_m = options.max_m + std::sqrt(drift_squared);
  left.max_deg = options.max_deg * std::sqrt(length / 3);
  return left;
}

CycleSearch::CycleSearch(const std::vector<CycleNode>& nodes, const std::vector<CycleEdge>& edges,
                         const CycleOptions& options)
    : nodes_(nodes), edges_(edges), options_(options), neighbours_(nodes.size()) {
  for (uint32_t e = 0; e < edges.size(); ++e) {
    neighbours_[edges[e].a].push_back({edges[e].b, e});
    neighbours_[edges[e].b].push_back({edges[e].a, e});
  }
  for (auto& list : neighbours_) {
    std::sort(list.begin(), list.end(),
              [](const Neighbour& l, const Neighbour& r) { return l.node < r.node; });
  }
  if (!AddTriangles()) {
    short_.clear();
    return;
  }
  longest_short_ = 3;
  const size_t triangles = short_.size();
  if (AddSquares()) {
    longest_short_ = 4;
  } else {
    short_.resize(triangles);
  }
}

const CycleSearch::Neighbour* CycleSearch::FindNeighbour(uint32_t from, uint32_t to) const {
  const auto& list = neighbours_[from];
  const auto it = std::lower_bound(list.begin(), list.end(), to,
                                   [](const Neighbour& n, uint32_t node) { return n.node < node; });
  return it == list.end() || it->node != to ? nullptr : &*it;
}

// These two are false, and leave nothing usable, when there are too many.
bool CycleSearch::AddTriangles() {
  for (const CycleEdge& edge : edges_) {
    for (const Neighbour& c : neighbours_[edge.b]) {
      if (c.node <= edge.b || !FindNeighbour(edge.a, c.node)) continue;
      if (short_.size() == options_.max_triangles) return false;
      short_.push_back(Measure({edge.a, edge.b, c.node}));
    }
  }
  return true;
}

bool CycleSearch::AddSquares() {
  const size_t most = short_.size() + options_.max_squares;
  for (uint32_t a = 0; a < nodes_.size(); ++a) {
    for (const Neighbour& b : neighbours_[a]) {
      if (b.node <= a) continue;
      for (const Neighbour& d : neighbours_[a]) {
        if (d.node <= b.node) continue;
        for (const Neighbour& c : neighbours_[b.node]) {
          if (c.node <= a || c.node == d.node || !FindNeighbour(d.node, c.node)) continue;
          if (short_.size() == most) return false;
          short_.push_back(Measure({a, b.node, c.node, d.node}));
        }
      }
    }
  }
  return true;
}

Cycle CycleSearch::Measure(std::vector<uint32_t> nodes) const {
  Cycle cycle;
  cycle.nodes = std::move(nodes);
  std::vector<Step> steps;
  for (size_t i = 0; i < cycle.nodes.size(); ++i) {
    const uint32_t from = cycle.nodes[i], to = cycle.nodes[(i + 1) % cycle.nodes.size()];
    const uint32_t e = FindNeighbour(from, to)->edge;
    cycle.edges.push_back(e);
    steps.push_back(
        {&nodes_[from], edges_[e].a == from ? edges_[e].T_a_b : edges_[e].T_a_b.Inverse()});
  }
  static_cast<Residual&>(cycle) = GoRound(steps, options_);
  return cycle;
}

void CycleSearch::AddThroughForest(const std::vector<bool>& active,
                                   std::vector<Cycle>* cycles) const {
  UnionFind sets(nodes_.size());
  std::vector<std::vector<uint32_t>> forest(nodes_.size());
  std::vector<uint32_t> closing;
  for (const uint32_t e : ByConfidence(edges_, active)) {
    const auto [a, b] = std::make_pair(edges_[e].a, edges_[e].b);
    if (!sets.Unite(a, b)) {
      closing.push_back(e);
      continue;
    }
    forest[a].push_back(b);
    forest[b].push_back(a);
  }
  const HungForest hung(nodes_.size(), forest);
  for (const uint32_t e : closing) {
    std::vector<uint32_t> path = hung.Path(edges_[e].a, edges_[e].b);
    if (path.size() <= longest_short_) continue;
    cycles->push_back(Measure(Canonical(std::move(path))));
  }
}

std::vector<Cycle> CycleSearch::Find(const std::vector<bool>& active) const {
  std::vector<Cycle> cycles;
  for (const Cycle& cycle : short_) {
    const bool whole =
        std::all_of(cycle.edges.begin(), cycle.edges.end(), [&](uint32_t e) { return active[e]; });
    if (whole) cycles.push_back(cycle);
  }
  AddThroughForest(active, &cycles);
  return cycles;
}

}  // namespace isthmus::match_graph
