#include "server/placement/graph_diff.h"

#include <set>
#include <utility>

#include "absl/container/flat_hash_set.h"
#include "core/geometry/near.h"
#include "server/placement/limits.h"
#include "server/pose_graph/limits.h"

namespace isthmus::placement {
namespace {

bool IsSame(const Pose& a, const Pose& b) {
  return a.rotation().coeffs() == b.rotation().coeffs() && a.translation() == b.translation();
}

bool IsSame(const pose_graph::Edge& a, const pose_graph::Edge& b) {
  return a.may_be_wrong == b.may_be_wrong && IsSame(a.T_a_b, b.T_a_b) &&
         a.information == b.information;
}

// The same but for a refinement, which does not make the one before a mistake.
bool IsNear(const pose_graph::Edge& a, const pose_graph::Edge& b) {
  return a.may_be_wrong == b.may_be_wrong &&
         AreNear(a.T_a_b, b.T_a_b, kRefinedM, kRefinedM / pose_graph::kLeverM);
}

bool IsSame(const Anchor& a, const Anchor& b) {
  return a.sigma_xy_m == b.sigma_xy_m && a.sigma_z_m == b.sigma_z_m && a.sigma_deg == b.sigma_deg &&
         IsSame(a.T_map_submap, b.T_map_submap);
}

// A match, by its sessions, or a loop closure.
using RecordKey = std::pair<bool, uint64_t>;

RecordKey KeyOfRecord(const EdgeKey& key) {
  if (key.source == Source::kLoop) return {true, key.loop};
  return {false, uint64_t{key.a.session} << 32 | key.b.session};
}

struct RecordStatus {
  size_t graph = 0;   // Its number among the last graphs.
  bool sure = false;  // By hand.
  int standing = 0, gone = 0;
  std::vector<NodeKey> loose;  // Ends of edges that are gone.
};

class Comparison {
 public:
  Comparison(const LastGraphs& last, const Input& input, const SessionNumbers& numbers,
             const GraphSet& now)
      : last_(last), input_(input), now_(now) {
    for (const Session& session : input.sessions) {
      const auto number = numbers.find(session.tree.session);
      if (number != numbers.end()) known_.insert(number->second);
    }
  }

  std::vector<GraphDiff> Run() {
    for (size_t i = 0; i < last_.set.graphs.size(); ++i) FindGone(i);
    for (const auto& [key, status] : record_status_) {
      if (status.gone == 0) continue;
      if (status.standing == 0) {
        anew_.insert(status.graph);
      } else {
        loose_.insert(status.loose.begin(), status.loose.end());
      }
    }
    FindGoneAnchors();
    std::vector<GraphDiff> changes;
    for (const Graph& graph : now_.graphs) changes.push_back(Compare(graph));
    return changes;
  }

 private:
  void FindGone(size_t index) {
    const Graph& graph = last_.set.graphs[index];
    for (const GraphSession& session : graph.sessions) {
      if (!known_.contains(session.number)) anew_.insert(index);
    }
    for (size_t i = graph.odometry_edges; i < graph.origins.size(); ++i) {
      const EdgeKey& key = graph.origins[i].key;
      RecordStatus& status = record_status_[KeyOfRecord(key)];
      status.graph = index;
      status.sure = !graph.problem.edges[i].may_be_wrong;
      const auto found = now_.edges.find(key);
      if (found != now_.edges.end()) {
        const auto& [place, edge] = found->second;
        const bool near = IsNear(now_.graphs[place].problem.edges[edge], graph.problem.edges[i]);
        ++(near ? status.standing : status.gone);
      } else if (now_.nodes.contains(key.a) && now_.nodes.contains(key.b)) {
        ++status.gone;
        status.loose.insert(status.loose.end(), {key.a, key.b});
      }
    }
  }

  void FindGoneAnchors() {
    for (const auto& [id, kept] : last_.anchors) {
      const auto graph = LastGraph(id.session);
      if (graph == kNoGraph || !IsInMap(id)) continue;
      const Anchor* anchor = FindAnchor(id);
      if (anchor == nullptr || !IsSame(*anchor, kept.anchor)) anew_.insert(graph);
    }
  }

  const Anchor* FindAnchor(const SubmapId& id) const {
    for (const Anchor& anchor : input_.anchors) {
      if (anchor.submap == id) return &anchor;
    }
    return nullptr;
  }

  bool IsInMap(const SubmapId& id) const {
    for (const Graph& graph : now_.graphs) {
      for (const GraphSession& session : graph.sessions) {
        if (graph.ids[static_cast<size_t>(session.first_node)].session != id.session) continue;
        return now_.nodes.contains({session.number, id.index});
      }
    }
    return false;
  }

  static constexpr size_t kNoGraph = static_cast<size_t>(-1);

  size_t LastGraph(const SessionId& id) const {
    for (size_t i = 0; i < last_.set.graphs.size(); ++i) {
      const Graph& graph = last_.set.graphs[i];
      for (const GraphSession& session : graph.sessions) {
        if (graph.ids[static_cast<size_t>(session.first_node)].session == id) return i;
      }
    }
    return kNoGraph;
  }

  GraphDiff Compare(const Graph& graph) const {
    GraphDiff change;
    std::set<size_t> parts;
    for (const GraphSession& session : graph.sessions) {
      const auto part = last_.set.sessions.find(session.number);
      if (part == last_.set.sessions.end()) {
        change.joined = true;
        continue;
      }
      parts.insert(part->second);
      if (anew_.contains(part->second)) change.anew = true;
    }
    change.unknown = parts.empty();
    if (parts.size() > 1) change.joined = true;
    const auto anchored = last_.anchored.find(graph.reference);
    const bool was_anchored = anchored != last_.anchored.end() && anchored->second;
    if (was_anchored && !graph.anchored) change.anew = true;
    change.new_anchor = !was_anchored && graph.anchored;
    for (const size_t anchor : graph.anchors) {
      if (!last_.anchors.contains(input_.anchors[anchor].submap)) change.new_anchor = true;
    }
    CompareEdges(graph, &change);
    return change;
  }

  void CompareEdges(const Graph& graph, GraphDiff* change) const {
    for (size_t i = 0; i < graph.origins.size(); ++i) {
      const EdgeKey& key = graph.origins[i].key;
      const bool loose = loose_.contains(key.a) || loose_.contains(key.b);
      change->loosened |= loose;
      const bool is_new = IsNew(key, graph.problem.edges[i]);
      if (is_new || loose) change->edges.push_back(static_cast<int>(i));
      if (!is_new || key.source == Source::kOdometry || key.source == Source::kLoop) continue;
      const auto status = record_status_.find(KeyOfRecord(key));
      const bool sure = !graph.problem.edges[i].may_be_wrong;
      if (status == record_status_.end() || status->second.sure != sure) change->new_match = true;
    }
  }

  bool IsNew(const EdgeKey& key, const pose_graph::Edge& edge) const {
    const auto found = last_.set.edges.find(key);
    if (found != last_.set.edges.end()) {
      const auto& [place, i] = found->second;
      return !IsSame(last_.set.graphs[place].problem.edges[i], edge);
    }
    // Between two that were there before, what lay in between was retired; they stay.
    return key.source != Source::kOdometry || !last_.set.nodes.contains(key.a) ||
           !last_.set.nodes.contains(key.b);
  }

  const LastGraphs& last_;
  const Input& input_;
  const GraphSet& now_;
  absl::flat_hash_set<uint32_t> known_;  // Sessions.
  absl::flat_hash_map<RecordKey, RecordStatus> record_status_;
  std::set<size_t> anew_;  // Numbers of last graphs.
  absl::flat_hash_set<NodeKey> loose_;
};

}  // namespace

std::vector<GraphDiff> DiffGraphs(const LastGraphs& last, const Input& input,
                                  const SessionNumbers& numbers, const GraphSet& now) {
  return Comparison(last, input, numbers, now).Run();
}

void InheritWeights(const LastGraphs& last, const Input& input, Graph* graph) {
  for (size_t i = 0; i < graph->origins.size(); ++i) {
    const auto found = last.set.edges.find(graph->origins[i].key);
    if (found == last.set.edges.end()) continue;
    const auto& [place, old] = found->second;
    const pose_graph::Edge& before = last.set.graphs[place].problem.edges[old];
    pose_graph::Edge& edge = graph->problem.edges[i];
    if (IsSame(before, edge)) edge.weight = before.weight;
  }
  for (size_t i = 0; i < graph->anchors.size(); ++i) {
    const Anchor& anchor = input.anchors[graph->anchors[i]];
    const auto found = last.anchors.find(anchor.submap);
    if (found == last.anchors.end() || !IsSame(found->second.anchor, anchor)) continue;
    graph->problem.anchors[i].weight = found->second.weight;
  }
}

}  // namespace isthmus::placement
