#include "server/placement/placer.h"

#include <algorithm>
#include <deque>
#include <utility>

#include "absl/strings/str_cat.h"
#include "core/concurrency/mutex.h"
#include "server/placement/anchor_fit.h"
#include "server/placement/graph_builder.h"
#include "server/placement/graph_diff.h"
#include "server/placement/graph_text.h"
#include "server/placement/initial_poses.h"
#include "server/placement/limits.h"
#include "server/placement/retired_gaps.h"
#include "server/placement/settle_poses.h"
#include "server/placement/solve_component.h"

namespace isthmus::placement {
namespace {

// Everything before the search. `placements` are where it goes on from.
void Start(const Input& input, const std::vector<Placement>& placements, const LastGraphs& base,
           const GraphDiff& change, Graph* graph) {
  pose_graph::Problem& problem = graph->problem;
  const auto found = base.anchored.find(graph->reference);
  const bool known = found != base.anchored.end();
  const bool was_anchored = known && found->second;
  if (change.anew) {
    BeginPosesAnew(input, placements, !known || was_anchored == graph->anchored, graph);
  } else {
    ContinuePoses(input, placements, graph);
    InheritWeights(base, input, graph);
  }
  if (problem.anchors.empty()) {
    problem.fixed = {graph->gauge};
    return;
  }
  if (change.anew || !was_anchored) {
    const Pose T = FitToAnchors(problem);
    for (Pose& pose : problem.poses) pose = T * pose;
  }
  KeepUpright(input, graph);
}

}  // namespace

struct Placer::Memory {
  SessionNumbers numbers;
  NearestPairs nearest;
  GapPoses gaps;
  mutable Mutex mutex;
  std::shared_ptr<const LastGraphs> last ABSL_GUARDED_BY(mutex) = std::make_shared<LastGraphs>();
  // Such as were before a match came, the newest last.
  std::deque<std::shared_ptr<const LastGraphs>> earlier;
  std::map<SessionId, int> partial;  // Optimisations since the last whole one, by reference.

  std::shared_ptr<const LastGraphs> Last() const {
    MutexLock lock(&mutex);
    return last;
  }

  struct Base {
    std::shared_ptr<const LastGraphs> graphs;
    GraphDiff change;  // Since then.
  };
  std::vector<Base> ChooseBases(const Input& input, const GraphSet& set) const;
  void KeepGraphs(const Input& input, const std::vector<Base>& bases, GraphSet set,
                  const std::vector<Placement>& placements);
};

// The graphs that each of the graphs goes on from: those of the last call, or, if something was
// taken back since, those from before that came, if nothing else that was there then is missing
// now. If there is no such thing, the change says that it begins anew.
std::vector<Placer::Memory::Base> Placer::Memory::ChooseBases(const Input& input,
                                                              const GraphSet& set) const {
  const std::shared_ptr<const LastGraphs> newest = Last();
  std::vector<Base> bases;
  bool missing = false;
  for (const GraphDiff& change : DiffGraphs(*newest, input, numbers, set)) {
    bases.push_back({newest, change});
    missing |= change.anew;
  }
  for (auto older = earlier.rbegin(); older != earlier.rend() && missing; ++older) {
    missing = false;
    const std::vector<GraphDiff> changes = DiffGraphs(**older, input, numbers, set);
    for (size_t i = 0; i < bases.size(); ++i) {
      if (!bases[i].change.anew) continue;
      if (changes[i].anew || changes[i].unknown) {
        missing = true;
      } else {
        bases[i] = {*older, changes[i]};
      }
    }
  }
  return bases;
}

void Placer::Memory::KeepGraphs(const Input& input, const std::vector<Base>& bases, GraphSet set,
                                const std::vector<Placement>& placements) {
  const std::shared_ptr<const LastGraphs> newest = Last();
  const bool new_match = std::any_of(bases.begin(), bases.end(), [&](const Base& base) {
    return base.graphs == newest && base.change.new_match;
  });
  if (new_match) earlier.push_back(newest);
  if (earlier.size() > kMaxEarlier) earlier.pop_front();
  const auto kept = std::make_shared<LastGraphs>();
  kept->placements = placements;
  for (const Graph& graph : set.graphs) {
    kept->anchored[graph.reference] = graph.anchored;
    for (size_t i = 0; i < graph.anchors.size(); ++i) {
      const Anchor& anchor = input.anchors[graph.anchors[i]];
      kept->anchors[anchor.submap] = {anchor, graph.problem.anchors[i].weight};
    }
  }
  std::erase_if(partial, [&](const auto& entry) { return !kept->anchored.contains(entry.first); });
  kept->set = std::move(set);
  MutexLock lock(&mutex);
  last = kept;
}

Placer::Placer(const PlacerOptions& options)
    : options_(options), memory_(std::make_unique<Memory>()) {}
Placer::~Placer() = default;
Placer::Placer(Placer&&) noexcept = default;
Placer& Placer::operator=(Placer&&) noexcept = default;

Outcome Placer::Place(const Input& input, const std::vector<Placement>& previous) {
  Memory& memory = *memory_;
  UpdateGaps(previous, input, &memory.gaps);
  GraphSet set = BuildGraphs(input, options_.drift, memory.gaps, &memory.numbers, &memory.nearest);
  const std::vector<Memory::Base> bases = memory.ChooseBases(input, set);
  const std::shared_ptr<const LastGraphs> newest = memory.Last();
  Outcome outcome;
  bool partial = false;
  for (size_t i = 0; i < set.graphs.size(); ++i) {
    Graph& graph = set.graphs[i];
    const auto& [base, change] = bases[i];
    Start(input, base == newest ? previous : base->placements, *base, change, &graph);
    int& partial_before = memory.partial[graph.reference];
    const Solved solved = SolveComponent(options_, change, partial_before, &graph);
    if (solved.whole) partial_before = 0;
    if (solved.partial) ++partial_before;
    outcome.whole |= solved.whole;
    partial |= solved.partial;
    outcome.converged &= solved.converged;
    if (!solved.trouble.empty()) {
      absl::StrAppend(&outcome.trouble, outcome.trouble.empty() ? "" : "; ", "map ",
                      graph.component, ": ", solved.trouble);
    }
    ReturnDiscardedToTree(input, &graph);
    SettlePoses(options_, previous, &graph);
    outcome.nodes += graph.ids.size();
    outcome.edges += graph.problem.edges.size();
    for (const GraphSession& session : graph.sessions) {
      outcome.placements.push_back(MakePlacement(input.sessions[session.session], session, graph));
    }
  }
  if (partial) outcome.whole = false;
  std::sort(outcome.placements.begin(), outcome.placements.end(),
            [](const Placement& a, const Placement& b) { return a.session < b.session; });
  outcome.edge_status = EdgeStatusOf(input, set);
  memory.KeepGraphs(input, bases, std::move(set), outcome.placements);
  return outcome;
}

absl::StatusOr<std::string> Placer::WriteG2o(const MapName& map) const {
  const std::shared_ptr<const LastGraphs> last = memory_->Last();
  const std::vector<Graph>& graphs = last->set.graphs;
  const auto number_of = [&graphs](const SessionId& session) -> std::optional<uint32_t> {
    for (const Graph& graph : graphs) {
      const auto is_of = [&session](const SubmapId& id) { return id.session == session; };
      if (std::ranges::any_of(graph.ids, is_of)) return graph.component;
    }
    return std::nullopt;
  };
  const auto number = NumberOf(map, static_cast<uint32_t>(graphs.size()), number_of);
  if (!number.ok()) return number.status();
  for (const Graph& graph : graphs) {
    if (graph.component == *number) return GraphText(graph);
  }
  return absl::NotFoundError("no map has submaps yet, so there is no pose graph");
}

}  // namespace isthmus::placement
