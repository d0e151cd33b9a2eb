#include "server/placement/initial_poses.h"

#include <algorithm>
#include <limits>
#include <map>
#include <optional>
#include <tuple>

#include "server/placement/graph_builder.h"
#include "server/placement/limits.h"

namespace isthmus::placement {
namespace {

const Session& SessionOf(const Input& input, const Graph& graph, int node, size_t* k) {
  for (const GraphSession& session : graph.sessions) {
    if (node >= session.first_node + session.node_count) continue;
    *k = static_cast<size_t>(node - session.first_node);
    return input.sessions[session.session];
  }
  *k = 0;
  return input.sessions[graph.sessions.front().session];
}

Pose RawTreePose(const Input& input, const Graph& graph, int node) {
  size_t k = 0;
  const Session& session = SessionOf(input, graph, node, &k);
  return session.tree.T_map_odom * session.nodes[k].T_odom_submap;
}

// A session by itself, in the frame of `placement`, or in odom where there is none.
void Shape(const Session& session, const Placement* placement, Pose* poses) {
  const std::vector<Node>& nodes = session.nodes;
  std::vector<const Pose*> known(nodes.size(), nullptr);
  size_t first = nodes.size();
  for (size_t k = 0; k < nodes.size() && placement != nullptr; ++k) {
    known[k] = FindPose(*placement, nodes[k].index);
    if (known[k] != nullptr && first == nodes.size()) first = k;
  }
  if (first == nodes.size()) {
    const Pose T = placement == nullptr ? Pose() : placement->T_map_odom;
    for (size_t k = 0; k < nodes.size(); ++k) {
      poses[k] = placement == nullptr ? nodes[k].T_odom_submap : T * nodes[k].T_odom_submap;
    }
    return;
  }
  const auto follow = [&](size_t to, size_t from) {
    poses[to] = poses[from] * (nodes[from].T_odom_submap.Inverse() * nodes[to].T_odom_submap);
  };
  poses[first] = *known[first];
  for (size_t k = first; k-- > 0;) follow(k, k + 1);
  for (size_t k = first + 1; k < nodes.size(); ++k) {
    if (known[k] != nullptr) {
      poses[k] = *known[k];
    } else {
      follow(k, k - 1);
    }
  }
}

// Sessions that lie in one frame move together.
class Joiner {
 public:
  Joiner(const Input& input, const std::vector<Placement>& previous, Graph* graph)
      : input_(input), graph_(*graph), poses_(graph->problem.poses), piece_(poses_.size()) {
    std::map<SessionId, size_t> frames;
    for (const GraphSession& session : graph_.sessions) {
      const Session& record = input.sessions[session.session];
      const Placement* placement = FindPlacement(previous, record.tree.session);
      Shape(record, placement, &poses_[static_cast<size_t>(session.first_node)]);
      const SessionId& frame = placement ? placement->reference : record.tree.session;
      const size_t piece = frames.emplace(frame, frames.size()).first->second;
      std::fill_n(piece_.begin() + session.first_node, session.node_count, piece);
    }
    placed_.assign(frames.size(), false);
    const auto base = frames.find(graph_.reference);
    if (base != frames.end()) {
      placed_[base->second] = true;
    } else {
      PlaceByTree(graph_.gauge);
    }
  }

  void Run() {
    for (;;) {
      const auto first = std::find_if(piece_.begin(), piece_.end(),
                                      [this](size_t piece) { return !placed_[piece]; });
      if (first == piece_.end()) return;
      const std::optional<size_t> match = SurestMatch();
      if (match) {
        PlaceByMatch(*match);
      } else {
        PlaceByTree(static_cast<int>(first - piece_.begin()));
      }
    }
  }

 private:
  size_t Piece(int node) const { return piece_[static_cast<size_t>(node)]; }
  const Pose& At(int node) const { return poses_[static_cast<size_t>(node)]; }

  void Move(size_t piece, const Pose& T) {
    for (size_t i = 0; i < poses_.size(); ++i) {
      if (piece_[i] == piece) poses_[i] = T * poses_[i];
    }
    placed_[piece] = true;
  }

  void PlaceByTree(int node) {
    const bool gauge_placed = placed_[Piece(graph_.gauge)];
    const Pose target =
        gauge_placed ? TreePose(input_, graph_, node) : RawTreePose(input_, graph_, node);
    Move(Piece(node), target * At(node).Inverse());
  }

  // True if an edge of a match leads from a placed piece to one that is not.
  bool LeadsOn(size_t edge) const {
    if (graph_.origins[edge].key.source == Source::kLoop) return false;
    const pose_graph::Edge& e = graph_.problem.edges[edge];
    return placed_[Piece(e.a)] != placed_[Piece(e.b)];
  }

  std::optional<size_t> SurestMatch() const {
    std::optional<size_t> best;
    const auto rank = [this](size_t record) {
      const Match& match = input_.matches[record];
      return std::tuple(IsByHand(match), match.confidence);
    };
    for (size_t i = graph_.odometry_edges; i < graph_.origins.size(); ++i) {
      if (!LeadsOn(i)) continue;
      const size_t record = graph_.origins[i].record;
      if (!best || rank(record) > rank(*best)) best = record;
    }
    return best;
  }

  // By that of its edges which the others agree with best.
  void PlaceByMatch(size_t record) {
    struct Vote {
      Pose T;
      Eigen::Vector3d at;
    };
    std::vector<Vote> votes;
    size_t piece = 0;
    for (size_t i = graph_.odometry_edges; i < graph_.origins.size(); ++i) {
      if (graph_.origins[i].record != record || !LeadsOn(i)) continue;
      if (votes.size() >= kMaxEdgesAsked) break;
      const pose_graph::Edge& e = graph_.problem.edges[i];
      const bool forward = placed_[Piece(e.a)];
      const int moved = forward ? e.b : e.a;
      const Pose target = forward ? At(e.a) * e.T_a_b : At(e.b) * e.T_a_b.Inverse();
      piece = Piece(moved);
      votes.push_back({target * At(moved).Inverse(), At(moved).translation()});
    }
    const Pose* best = nullptr;
    double least = std::numeric_limits<double>::infinity();
    for (const Vote& vote : votes) {
      double sum = 0;
      for (const Vote& other : votes) sum += (vote.T * other.at - other.T * other.at).norm();
      if (sum >= least) continue;
      least = sum;
      best = &vote.T;
    }
    Move(piece, best == nullptr ? Pose() : *best);
  }

  const Input& input_;
  const Graph& graph_;
  std::vector<Pose>& poses_;
  std::vector<size_t> piece_;  // By node.
  std::vector<bool> placed_;   // By piece.
};

}  // namespace

void ContinuePoses(const Input& input, const std::vector<Placement>& previous, Graph* graph) {
  Joiner(input, previous, graph).Run();
}

void BeginPosesAnew(const Input& input, const std::vector<Placement>& previous, bool same_frame,
                    Graph* graph) {
  std::vector<Pose>& poses = graph->problem.poses;
  size_t edge = 0;  // Edges of odometry come first, in order of the nodes.
  for (const GraphSession& session : graph->sessions) {
    const Session& record = input.sessions[session.session];
    const size_t first = static_cast<size_t>(session.first_node), count = record.nodes.size();
    for (size_t k = 0; k < count; ++k) {
      poses[first + k] = record.tree.T_map_odom * record.nodes[k].T_odom_submap;
    }
    // Up to the last gap, the newest submaps do not lie by odometry.
    size_t run = count - 1;
    while (run > 0 && record.nodes[run - 1].index + 1 == record.nodes[run].index) --run;
    for (size_t k = run; k-- > 0;) {
      poses[first + k] = poses[first + k + 1] * graph->problem.edges[edge + k].T_a_b.Inverse();
    }
    edge += count - 1;
  }
  const SubmapId& gauge = graph->ids[static_cast<size_t>(graph->gauge)];
  const Placement* placement = same_frame ? FindPlacement(previous, gauge.session) : nullptr;
  if (placement == nullptr || placement->reference != graph->reference) return;
  const Pose* pose = FindPose(*placement, gauge.index);
  if (pose == nullptr) return;
  const Pose T = *pose * poses[static_cast<size_t>(graph->gauge)].Inverse();
  for (Pose& moved : poses) moved = T * moved;
}

Pose TreePose(const Input& input, const Graph& graph, int node) {
  const Pose& gauge = graph.problem.poses[static_cast<size_t>(graph.gauge)];
  return gauge * RawTreePose(input, graph, graph.gauge).Inverse() * RawTreePose(input, graph, node);
}

const Placement* FindPlacement(const std::vector<Placement>& placements, const SessionId& session) {
  const auto found = std::lower_bound(
      placements.begin(), placements.end(), session,
      [](const Placement& placement, const SessionId& id) { return placement.session < id; });
  return found != placements.end() && found->session == session ? &*found : nullptr;
}

const Pose* FindPose(const Placement& placement, uint32_t index) {
  const auto found =
      std::lower_bound(placement.submaps.begin(), placement.submaps.end(), index,
                       [](const SubmapPose& submap, uint32_t i) { return submap.index < i; });
  return found != placement.submaps.end() && found->index == index ? &found->T_map_submap : nullptr;
}

}  // namespace isthmus::placement
