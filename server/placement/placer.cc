#include "server/placement/placer.h"

#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"
#include "server/placement/anchor_fit.h"
#include "server/placement/changes.h"
#include "server/placement/graph_builder.h"
#include "server/placement/graph_text.h"
#include "server/placement/initial_poses.h"
#include "server/placement/solve.h"

namespace isthmus::placement {
namespace {

// The poses that readers get: those that they have, where little has changed.
void Settle(const PlacerOptions& options, const std::vector<Placement>& previous, Graph* graph) {
  for (const GraphSession& session : graph->sessions) {
    const size_t first = static_cast<size_t>(session.first_node);
    const Placement* placement = FindPlacement(previous, graph->ids[first].session);
    if (placement == nullptr || placement->reference != graph->reference) continue;
    for (size_t i = first; i < first + static_cast<size_t>(session.node_count); ++i) {
      const Pose* before = FindPose(*placement, graph->ids[i].index);
      if (before == nullptr) continue;
      Pose& pose = graph->problem.poses[i];
      const Pose moved = before->Inverse() * pose;
      if (moved.translation().norm() < options.min_move_m &&
          RotationAngle(moved) < options.min_turn_rad) {
        pose = *before;
      }
    }
  }
}

Placement MakePlacement(const Session& session, const GraphSession& place, const Graph& graph) {
  Placement placement{session.tree.session, graph.component, graph.reference, {}};
  placement.submaps.reserve(session.nodes.size());
  for (size_t k = 0; k < session.nodes.size(); ++k) {
    placement.submaps.push_back(
        {session.nodes[k].index, graph.problem.poses[static_cast<size_t>(place.first_node) + k]});
  }
  placement.T_map_odom =
      placement.submaps.back().T_map_submap * session.nodes.back().T_odom_submap.Inverse();
  return placement;
}

// Edges that were passed over are not said to be discarded.
Judgement Judge(const Input& input, const GraphSet& set) {
  Judgement judgement;
  for (const Match& match : input.matches) {
    if (Counts(match)) judgement.matches[{match.a, match.b}].assign(match.edges.size(), true);
  }
  for (const LoopClosure& loop : input.loops) {
    if (!loop.rejected) judgement.loops[loop.id].assign(loop.edges.size(), true);
  }
  for (const Graph& graph : set.graphs) {
    for (size_t i = graph.odometry_edges; i < graph.origins.size(); ++i) {
      const EdgeOrigin& origin = graph.origins[i];
      const bool kept = graph.problem.edges[i].weight > 0;
      if (origin.key.source == Source::kMatch) {
        const Match& match = input.matches[origin.record];
        judgement.matches[{match.a, match.b}][origin.edge] = kept;
      } else if (origin.key.source == Source::kLoop) {
        judgement.loops[origin.key.loop][origin.edge] = kept;
      }
    }
    for (size_t i = 0; i < graph.anchors.size(); ++i) {
      judgement.anchors[input.anchors[graph.anchors[i]].submap] =
          graph.problem.anchors[i].weight > 0;
    }
  }
  return judgement;
}

}  // namespace

struct Placer::Memory {
  SessionNumbers numbers;
  NearestPairs nearest;
  LastGraphs last;
  std::map<SessionId, int> partial;  // Optimisations since the last whole one, by reference.

  void Start(const Input& input, const std::vector<Placement>& previous, const Change& change,
             Graph* graph) const;
  void Keep(const Input& input, GraphSet set);
};

// Everything before the search.
void Placer::Memory::Start(const Input& input, const std::vector<Placement>& previous,
                           const Change& change, Graph* graph) const {
  pose_graph::Problem& problem = graph->problem;
  if (change.anew) {
    const auto was = last.anchored.find(graph->reference);
    BeginPosesAnew(input, previous, was == last.anchored.end() || was->second == graph->anchored,
                   graph);
  } else {
    ContinuePoses(input, previous, graph);
  }
  if (problem.anchors.empty()) {
    problem.fixed = {graph->gauge};
    return;
  }
  const auto was = last.anchored.find(graph->reference);
  if (change.anew || was == last.anchored.end() || !was->second) {
    const Pose T = FitToAnchors(problem);
    for (Pose& pose : problem.poses) pose = T * pose;
  }
  KeepUpright(input, graph);
}

void Placer::Memory::Keep(const Input& input, GraphSet set) {
  last = {};
  for (const Graph& graph : set.graphs) {
    last.anchored[graph.reference] = graph.anchored;
    for (size_t i = 0; i < graph.anchors.size(); ++i) {
      const Anchor& anchor = input.anchors[graph.anchors[i]];
      last.anchors[anchor.submap] = {anchor, graph.problem.anchors[i].weight};
    }
  }
  for (auto it = partial.begin(); it != partial.end();) {
    it = last.anchored.contains(it->first) ? std::next(it) : partial.erase(it);
  }
  last.set = std::move(set);
}

Placer::Placer(const PlacerOptions& options)
    : options_(options), memory_(std::make_unique<Memory>()) {}
Placer::~Placer() = default;
Placer::Placer(Placer&&) noexcept = default;
Placer& Placer::operator=(Placer&&) noexcept = default;

Outcome Placer::Place(const Input& input, const std::vector<Placement>& previous) {
  Memory& memory = *memory_;
  GraphSet set = BuildGraphs(input, options_.drift, &memory.numbers, &memory.nearest);
  const std::vector<Change> changes = FindChanges(memory.last, input, memory.numbers, &set);
  Outcome outcome;
  bool partial = false;
  for (size_t i = 0; i < set.graphs.size(); ++i) {
    Graph& graph = set.graphs[i];
    memory.Start(input, previous, changes[i], &graph);
    int& partial_before = memory.partial[graph.reference];
    const Solved solved = Solve(options_, changes[i], partial_before, &graph);
    if (solved.whole) partial_before = 0;
    if (solved.partial) ++partial_before;
    outcome.whole |= solved.whole;
    partial |= solved.partial;
    outcome.converged &= solved.converged;
    if (!solved.trouble.empty()) {
      absl::StrAppend(&outcome.trouble, outcome.trouble.empty() ? "" : "; ", "component ",
                      graph.component, ": ", solved.trouble);
    }
    ReturnDiscardedToTree(input, &graph);
    Settle(options_, previous, &graph);
    outcome.nodes += graph.ids.size();
    outcome.edges += graph.problem.edges.size();
    for (const GraphSession& session : graph.sessions) {
      outcome.placements.push_back(MakePlacement(input.sessions[session.session], session, graph));
    }
  }
  if (partial) outcome.whole = false;
  std::sort(outcome.placements.begin(), outcome.placements.end(),
            [](const Placement& a, const Placement& b) { return a.session < b.session; });
  outcome.judgement = Judge(input, set);
  memory.Keep(input, std::move(set));
  return outcome;
}

absl::StatusOr<std::string> Placer::WriteG2o(uint32_t component) const {
  for (const Graph& graph : memory_->last.set.graphs) {
    if (graph.component == component) return GraphText(graph);
  }
  return absl::NotFoundError(absl::StrCat("there is no component ", component, "; there are ",
                                          memory_->last.set.graphs.size()));
}

}  // namespace isthmus::placement
