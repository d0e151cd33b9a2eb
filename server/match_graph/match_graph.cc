#include "server/match_graph/match_graph.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <tuple>

#include "core/union_find.h"

namespace isthmus::match_graph {
namespace {

struct Edge {
  size_t match = 0;     // Index into the matches given.
  size_t a = 0, b = 0;  // Indices into the sorted nodes; T_a_b of the match.
};

// The role of a session in the previous placements.
struct Past {
  SessionId reference;
  size_t component_size = 0;  // Sessions of that component that are still there.
  uint32_t number = 0;        // Number of the component.
};

using Component = std::vector<size_t>;  // Indices into the sorted nodes, ascending.

// In order of session; of a session named twice the heavier node stays.
std::vector<Node> SortedNodes(std::vector<Node> nodes) {
  std::sort(nodes.begin(), nodes.end(), [](const Node& l, const Node& r) {
    return std::tie(l.session, r.weight) < std::tie(r.session, l.weight);
  });
  nodes.erase(std::unique(nodes.begin(), nodes.end(),
                          [](const Node& l, const Node& r) { return l.session == r.session; }),
              nodes.end());
  return nodes;
}

std::optional<size_t> IndexOf(const std::vector<Node>& nodes, const SessionId& session) {
  const auto it =
      std::lower_bound(nodes.begin(), nodes.end(), session,
                       [](const Node& node, const SessionId& id) { return node.session < id; });
  if (it == nodes.end() || it->session != session) return std::nullopt;
  return static_cast<size_t>(it - nodes.begin());
}

// Usable edges, the most confident first. Equal confidences fall back on the names of the pair, so
// that the tree does not depend on the order in which matches were found.
std::vector<Edge> SortedEdges(const std::vector<Node>& nodes, const std::vector<Match>& matches) {
  std::vector<Edge> edges;
  for (size_t i = 0; i < matches.size(); ++i) {
    if (!MayCarry(matches[i])) continue;
    const auto a = IndexOf(nodes, matches[i].a), b = IndexOf(nodes, matches[i].b);
    if (a && b && a != b) edges.push_back({i, *a, *b});
  }
  std::sort(edges.begin(), edges.end(), [&](const Edge& l, const Edge& r) {
    const double confidence_l = matches[l.match].confidence;
    const double confidence_r = matches[r.match].confidence;
    if (confidence_l != confidence_r) return confidence_l > confidence_r;
    return std::make_tuple(std::minmax(l.a, l.b), l.a, l.match) <
           std::make_tuple(std::minmax(r.a, r.b), r.a, r.match);
  });
  return edges;
}

// Kruskal's maximum spanning forest; `sets` ends up as the components.
std::vector<Edge> SpanningForest(const std::vector<Edge>& edges, UnionFind* sets) {
  std::vector<Edge> forest;
  for (const Edge& edge : edges) {
    if (sets->Unite(edge.a, edge.b)) forest.push_back(edge);
  }
  return forest;
}

std::vector<Component> Components(size_t node_count, UnionFind* sets) {
  std::map<size_t, Component> by_root;
  for (size_t i = 0; i < node_count; ++i) by_root[sets->Find(i)].push_back(i);
  std::vector<Component> components;
  for (auto& [root, component] : by_root) components.push_back(std::move(component));
  return components;
}

std::map<SessionId, Past> PastOf(const std::vector<Node>& nodes,
                                 const std::vector<Placement>& previous) {
  std::map<SessionId, size_t> size_by_reference;
  for (const Placement& placement : previous) {
    if (IndexOf(nodes, placement.session)) ++size_by_reference[placement.reference];
  }
  std::map<SessionId, Past> past;
  for (const Placement& placement : previous) {
    past[placement.session] = {placement.reference, size_by_reference[placement.reference],
                               placement.component};
  }
  return past;
}

// A session that was a reference goes before one that was not, the reference of more sessions
// before that of fewer, the heavier before the lighter.
size_t ChooseReference(const std::vector<Node>& nodes, const Component& component,
                       const std::map<SessionId, Past>& past) {
  const auto rank = [&](size_t i) {
    const auto it = past.find(nodes[i].session);
    const bool was_reference = it != past.end() && it->second.reference == nodes[i].session;
    return std::make_pair(was_reference ? it->second.component_size : 0, nodes[i].weight);
  };
  // max_element keeps the first of equals: the smallest session id.
  return *std::max_element(component.begin(), component.end(),
                           [&](size_t l, size_t r) { return rank(l) < rank(r); });
}

// The smallest number of those under which its sessions were known; beyond all for new ones.
uint32_t FirstNumber(const std::vector<Node>& nodes, const Component& component,
                     const std::map<SessionId, Past>& past) {
  uint32_t first = std::numeric_limits<uint32_t>::max();
  for (const size_t i : component) {
    const auto it = past.find(nodes[i].session);
    if (it != past.end()) first = std::min(first, it->second.number);
  }
  return first;
}

// Walks the forest from every reference; T_map_odom by node.
std::vector<Pose> WalkForest(const std::vector<size_t>& references, const std::vector<Edge>& forest,
                             const std::vector<Match>& matches, size_t node_count) {
  std::vector<std::vector<std::pair<size_t, Pose>>> neighbours(node_count);  // (j, T_i_j) of i.
  for (const Edge& edge : forest) {
    const Pose& T_a_b = matches[edge.match].T_a_b;
    neighbours[edge.a].emplace_back(edge.b, T_a_b);
    neighbours[edge.b].emplace_back(edge.a, T_a_b.Inverse());
  }
  std::vector<Pose> T_map_odom(node_count);
  std::vector<bool> reached(node_count, false);
  std::vector<size_t> open = references;
  for (const size_t reference : references) reached[reference] = true;
  while (!open.empty()) {
    const size_t i = open.back();
    open.pop_back();
    for (const auto& [j, T_i_j] : neighbours[i]) {
      if (reached[j]) continue;
      reached[j] = true;
      T_map_odom[j] = T_map_odom[i] * T_i_j;
      open.push_back(j);
    }
  }
  return T_map_odom;
}

}  // namespace

bool MayCarry(const Match& match) {
  return match.state == MatchState::kAccepted && std::isfinite(match.confidence) &&
         match.T_a_b.IsFinite();
}

Solution Solve(const std::vector<Node>& given_nodes, const std::vector<Match>& matches,
               const std::vector<Placement>& previous) {
  const std::vector<Node> nodes = SortedNodes(given_nodes);
  UnionFind sets(nodes.size());
  const std::vector<Edge> forest = SpanningForest(SortedEdges(nodes, matches), &sets);
  const std::map<SessionId, Past> past = PastOf(nodes, previous);

  std::vector<std::pair<size_t, Component>> components;  // Reference, members.
  for (Component& component : Components(nodes.size(), &sets)) {
    const size_t reference = ChooseReference(nodes, component, past);
    components.emplace_back(reference, std::move(component));
  }
  const auto rank = [&](const std::pair<size_t, Component>& component) {
    return std::make_tuple(-static_cast<int64_t>(component.second.size()),
                           FirstNumber(nodes, component.second, past), component.first);
  };
  std::sort(components.begin(), components.end(),
            [&](const auto& l, const auto& r) { return rank(l) < rank(r); });

  std::vector<size_t> references;
  for (const auto& [reference, members] : components) references.push_back(reference);
  const std::vector<Pose> T_map_odom = WalkForest(references, forest, matches, nodes.size());

  Solution solution;
  solution.placements.resize(nodes.size());
  for (size_t c = 0; c < components.size(); ++c) {
    const SessionId& reference = nodes[components[c].first].session;
    for (const size_t i : components[c].second) {
      solution.placements[i] = {nodes[i].session, static_cast<uint32_t>(c), reference,
                                T_map_odom[i]};
    }
  }
  for (const Edge& edge : forest) solution.tree.push_back(edge.match);
  return solution;
}

std::optional<Pose> FindTransform(const std::vector<Placement>& placements, const SessionId& a,
                                  const SessionId& b) {
  const Placement* placed_a = nullptr;
  const Placement* placed_b = nullptr;
  for (const Placement& placement : placements) {
    if (placement.session == a) placed_a = &placement;
    if (placement.session == b) placed_b = &placement;
  }
  if (!placed_a || !placed_b || placed_a->component != placed_b->component) return std::nullopt;
  return placed_a->T_map_odom.Inverse() * placed_b->T_map_odom;
}

}  // namespace isthmus::match_graph
