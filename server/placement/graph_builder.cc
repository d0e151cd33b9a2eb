#include "server/placement/graph_builder.h"

#include <algorithm>
#include <limits>
#include <optional>

#include "core/geometry/angles.h"
#include "server/placement/edge_information.h"
#include "server/placement/limits.h"

namespace isthmus::placement {
namespace {

class Builder {
 public:
  Builder(const Input& input, const pose_graph::DriftModel& drift, const GapPoses& gaps,
          SessionNumbers* numbers, NearestPairs* nearest)
      : input_(input), drift_(drift), gaps_(gaps), numbers_(*numbers), nearest_(*nearest) {}

  GraphSet Build() {
    AddSessions();
    for (size_t i = 0; i < input_.matches.size(); ++i) {
      if (IsAccepted(input_.matches[i])) AddMatch(i);
    }
    for (size_t i = 0; i < input_.loops.size(); ++i) {
      if (!input_.loops[i].rejected) AddLoop(i);
    }
    AddAnchors();
    return std::move(set_);
  }

 private:
  uint32_t Number(const SessionId& session) {
    return numbers_.emplace(session, static_cast<uint32_t>(numbers_.size())).first->second;
  }

  void AddSessions() {
    std::map<uint32_t, std::vector<size_t>> components;
    for (size_t i = 0; i < input_.sessions.size(); ++i) {
      if (!input_.sessions[i].nodes.empty()) {
        components[input_.sessions[i].tree.component].push_back(i);
      }
    }
    for (const auto& [component, sessions] : components) {
      Graph& graph = set_.graphs.emplace_back();
      graph.component = component;
      graph.reference = input_.sessions[sessions.front()].tree.reference;
      for (const size_t session : sessions) AddSession(session);
      graph.odometry_edges = graph.problem.edges.size();
    }
  }

  // To the last graph.
  void AddSession(size_t index) {
    const Session& session = input_.sessions[index];
    Graph& graph = set_.graphs.back();
    const size_t place = set_.graphs.size() - 1;
    const uint32_t number = Number(session.tree.session);
    const int first = static_cast<int>(graph.ids.size());
    if (session.tree.session == graph.reference) graph.gauge = first;
    graph.sessions.push_back({index, number, first, static_cast<int>(session.nodes.size())});
    set_.sessions[number] = place;
    for (size_t k = 0; k < session.nodes.size(); ++k) {
      const Node& node = session.nodes[k];
      const NodeKey key{number, node.index};
      const int i = first + static_cast<int>(k);
      graph.ids.push_back({session.tree.session, node.index});
      graph.keys.push_back(key);
      set_.nodes[key] = {place, i};
      if (k == 0) continue;
      const Node& before = session.nodes[k - 1];
      const Pose T = StepBetween(session.tree.session, before, node, gaps_);
      AddEdge(place, {i - 1, i, T, DriftInformation(before, node, drift_), false},
              {{Source::kOdometry, 0, {number, before.index}, key}});
    }
    graph.problem.poses.resize(graph.ids.size());
  }

  void AddEdge(size_t place, const pose_graph::Edge& edge, EdgeOrigin origin) {
    Graph& graph = set_.graphs[place];
    const std::pair<size_t, size_t> here{place, graph.problem.edges.size()};
    while (!set_.edges.emplace(origin.key, here).second) ++origin.key.copy;
    graph.problem.edges.push_back(edge);
    graph.origins.push_back(origin);
  }

  // True if both submaps are in the map, in one component.
  bool AddSubmapEdge(const EdgeOrigin& origin, const SubmapEdge& edge, bool sure) {
    const auto a = set_.nodes.find(origin.key.a), b = set_.nodes.find(origin.key.b);
    if (a == set_.nodes.end() || b == set_.nodes.end()) return false;
    const auto& [graph_a, node_a] = a->second;
    const auto& [graph_b, node_b] = b->second;
    if (graph_a != graph_b || node_a == node_b || !IsUsable(edge.T_a_b, edge.information)) {
      return false;
    }
    AddEdge(graph_a, {node_a, node_b, edge.T_a_b, edge.information, !sure}, origin);
    return true;
  }

  void AddMatch(size_t record) {
    const Match& match = input_.matches[record];
    const uint32_t a = Number(match.a), b = Number(match.b);
    bool any = false;
    // Edges of a match whose transform a person gave are of the earlier, computed transform.
    const bool given = IsByHand(match) && match.matcher == GuessSource::kByHand;
    for (size_t k = 0; k < match.edges.size() && !given; ++k) {
      const SubmapEdge& edge = match.edges[k];
      const EdgeKey key{Source::kMatch, 0, {a, edge.submap_a}, {b, edge.submap_b}};
      any |= AddSubmapEdge({key, record, k}, edge, IsByHand(match));
    }
    if (any) {
      nearest_.erase({a, b});
    } else {
      AddNearest(record, a, b);
    }
  }

  void AddNearest(size_t record, uint32_t a, uint32_t b) {
    const Match& match = input_.matches[record];
    const std::optional<NearestPair> pair = FindNearest(match, a, b);
    if (!pair) return;
    nearest_[{a, b}] = *pair;
    SubmapEdge edge{pair->a, pair->b, {}, {}};
    edge.T_a_b = OdomPose({a, pair->a}).Inverse() * match.T_a_b * OdomPose({b, pair->b});
    edge.information = IsByHand(match) ? IsotropicInformation(kByHandM, kByHandRad)
                                       : IsotropicInformation(kWeakM, kWeakRad);
    const EdgeKey key{Source::kNearest, 0, {a, pair->a}, {b, pair->b}};
    AddSubmapEdge({key, record, 0}, edge, IsByHand(match));
  }

  const Session* FindSession(uint32_t number) const {
    const auto graph = set_.sessions.find(number);
    if (graph == set_.sessions.end()) return nullptr;
    for (const GraphSession& session : set_.graphs[graph->second].sessions) {
      if (session.number == number) return &input_.sessions[session.session];
    }
    return nullptr;
  }

  Pose OdomPose(const NodeKey& key) const {
    for (const Node& node : FindSession(key.session)->nodes) {
      if (node.index == key.index) return node.T_odom_submap;
    }
    return Pose();
  }

  std::optional<NearestPair> FindNearest(const Match& match, uint32_t a, uint32_t b) const {
    const Session* session_a = FindSession(a);
    const Session* session_b = FindSession(b);
    if (session_a == nullptr || session_b == nullptr) return std::nullopt;
    const auto known = nearest_.find({a, b});
    if (known != nearest_.end() && set_.nodes.contains({a, known->second.a}) &&
        set_.nodes.contains({b, known->second.b}) &&
        known->second.T_a_b.Matrix() == match.T_a_b.Matrix()) {
      return known->second;
    }
    NearestPair nearest{match.T_a_b};
    double least = std::numeric_limits<double>::infinity();
    for (const Node& node_b : session_b->nodes) {
      const Eigen::Vector3d at = match.T_a_b * node_b.T_odom_submap.translation();
      for (const Node& node_a : session_a->nodes) {
        const double apart = (node_a.T_odom_submap.translation() - at).squaredNorm();
        if (apart >= least) continue;
        least = apart;
        nearest.a = node_a.index;
        nearest.b = node_b.index;
      }
    }
    return nearest;
  }

  void AddLoop(size_t record) {
    const LoopClosure& loop = input_.loops[record];
    const auto number = numbers_.find(loop.session);
    if (number == numbers_.end()) return;
    for (size_t k = 0; k < loop.edges.size(); ++k) {
      const SubmapEdge& edge = loop.edges[k];
      const EdgeKey key{
          Source::kLoop, loop.id, {number->second, edge.submap_a}, {number->second, edge.submap_b}};
      AddSubmapEdge({key, record, k}, edge, false);
    }
  }

  void AddAnchors() {
    for (size_t i = 0; i < input_.anchors.size(); ++i) {
      const Anchor& anchor = input_.anchors[i];
      const auto number = numbers_.find(anchor.submap.session);
      if (number == numbers_.end()) continue;
      const auto session = set_.sessions.find(number->second);
      const Matrix6d information = AnchorInformation(anchor);
      if (session == set_.sessions.end() || !IsUsable(anchor.T_map_submap, information)) continue;
      Graph& graph = set_.graphs[session->second];
      graph.anchored = true;
      const auto node = set_.nodes.find({number->second, anchor.submap.index});
      if (node == set_.nodes.end()) continue;
      graph.problem.anchors.push_back(
          {node->second.second, anchor.T_map_submap, information, false});
      graph.anchors.push_back(i);
    }
    for (Graph& graph : set_.graphs) {
      for (pose_graph::Anchor& anchor : graph.problem.anchors) {
        anchor.may_be_wrong = graph.problem.anchors.size() >= kAnchorsToDoubt;
      }
    }
  }

  const Input& input_;
  const pose_graph::DriftModel& drift_;
  const GapPoses& gaps_;
  SessionNumbers& numbers_;
  NearestPairs& nearest_;
  GraphSet set_;
};

}  // namespace

bool IsAccepted(const Match& match) {
  return match.state == MatchState::kAccepted && match.T_a_b.IsFinite();
}

bool IsByHand(const Match& match) { return match.reason == MatchReason::kByHand; }

GraphSet BuildGraphs(const Input& input, const pose_graph::DriftModel& drift, const GapPoses& gaps,
                     SessionNumbers* numbers, NearestPairs* nearest) {
  return Builder(input, drift, gaps, numbers, nearest).Build();
}

}  // namespace isthmus::placement
