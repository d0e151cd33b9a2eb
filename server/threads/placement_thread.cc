#include "server/threads/placement_thread.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/str_join.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "core/caught.h"
#include "core/concurrency/mutex.h"
#include "core/concurrency/thread_role.h"
#include "core/stopwatch.h"
#include "server/match_graph/match_graph.h"
#include "server/threads/limits.h"

namespace isthmus::server {
namespace {

// Fills in what the spanning tree says of the sessions; its matches, in order.
std::vector<SessionPair> PlaceByTree(const std::vector<match_graph::Node>& nodes,
                                     const std::vector<Placement>& previous,
                                     placement::Input* input) {
  match_graph::Solution solution = match_graph::Solve(nodes, input->matches, previous);
  // Both are in order of session, and of the same sessions.
  for (size_t i = 0; i < input->sessions.size(); ++i) {
    input->sessions[i].tree = solution.placements[i];
  }
  std::vector<SessionPair> tree;
  for (const size_t edge : solution.tree) {
    tree.emplace_back(input->matches[edge].a, input->matches[edge].b);
  }
  std::sort(tree.begin(), tree.end());
  return tree;
}

bool SameFrames(const std::vector<Placement>& a, const std::vector<Placement>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const auto& x, const auto& y) {
    return x.session == y.session && x.component == y.component && x.reference == y.reference;
  });
}

template <typename T>
std::vector<T> Unique(std::vector<T> items) {
  std::sort(items.begin(), items.end());
  items.erase(std::unique(items.begin(), items.end()), items.end());
  return items;
}

}  // namespace

PlacementThread::PlacementThread(MapWriter* map, Activity* activity, storage::MapStore* store,
                                 const Clock* clock, const placement::PlacerOptions& options,
                                 OnProblem on_problem)
    : map_(map),
      activity_(activity),
      store_(store),
      clock_(clock),
      options_(options),
      on_problem_(std::move(on_problem)),
      placer_(options) {
  thread_ = std::thread([this] { Run(); });
}

PlacementThread::~PlacementThread() {
  Stop();
  thread_.join();
}

void PlacementThread::Stop() {
  stop_ = true;
  map_->changed().Notify();
}

absl::StatusOr<std::string> PlacementThread::WriteG2o(const MapName& map) {
  MutexLock lock(&placer_mutex_);
  return placer_.WriteG2o(map);
}

void PlacementThread::Run() {
  NameThread("placement");
  LowerPriority(kPlacementNice);
  while (true) {
    const uint64_t seen = map_->changed().count();
    if (!map_->view()->IsPlaced()) {
      PlaceMap();
    } else if (stop_) {
      break;
    } else {
      map_->changed().WaitPast(seen);
    }
  }
  map_->EndPlacing();
}

std::shared_ptr<const MapRevision> PlacementThread::MakeRevision(
    const MapRevision& previous, const Changes& changes, std::vector<SubmapMove> moves,
    std::vector<Placement> placements) {
  storage::WriteBatch batch;
  batch.moves = stored_ ? placement::FindMoves(stored_->placements, placements) : std::move(moves);
  MapRevision next;
  next.revision = previous.revision + 1;
  next.stamp_ns = clock_->NowNs();
  next.cause = absl::StrJoin(changes.causes, "; ");
  next.matches = Unique(changes.matches);
  next.loops = Unique(changes.loops);
  next.placements = std::move(placements);
  batch.revision = std::move(next);
  const bool is_stored = store_->Write(batch).ok();
  if (is_stored) {
    stored_ = nullptr;
  } else if (!stored_) {
    stored_ = std::make_shared<const MapRevision>(previous);
  }
  return std::make_shared<const MapRevision>(*std::move(batch.revision));
}

void PlacementThread::PlaceMap() {
  const MapWriter::ToPlace task = map_->TakeChanges();
  const Stopwatch watch;
  PlacedMap placed;
  try {
    placed = Solve(task);
  } catch (...) {
    const absl::Status caught = CaughtStatus();
    map_->GiveBack(task.changes);
    {
      MutexLock placing(&placer_mutex_);
      placer_ = placement::Placer(options_);
    }
    placed = PlacedMap();
    placed.tree = *task.view->tree;
    placed.edge_status = *task.view->edge_status;
    if (on_problem_) {
      on_problem_(absl::StrCat("what is new (", absl::StrJoin(task.changes.causes, "; "),
                               ") could not be placed: ", caught.message(),
                               "; it is tried again with the next change"));
    }
  }
  placed.version = task.view->graph_version;
  activity_->NotePlacement(watch.Ms());
  map_->ShowPlaced(std::move(placed));
}

PlacedMap PlacementThread::Solve(const MapWriter::ToPlace& task) {
  const MapView& view = *task.view;
  placement::Input input = PlacementInput(view);
  // Nobody else makes revisions.
  const std::vector<Placement>& previous = view.revision->placements;

  PlacedMap placed;
  placed.tree = PlaceByTree(MatchGraphNodes(view), previous, &input);
  placement::Outcome outcome;
  {
    MutexLock placing(&placer_mutex_);
    outcome = placer_.Place(input, previous);
  }
  placed.edge_status = std::move(outcome.edge_status);
  if (store_ == nullptr) return placed;
  std::vector<SubmapMove> moves = placement::FindMoves(previous, outcome.placements);
  if (!moves.empty() || !SameFrames(previous, outcome.placements)) {
    placed.revision =
        MakeRevision(*view.revision, task.changes, std::move(moves), std::move(outcome.placements));
  }
  return placed;
}

}  // namespace isthmus::server
