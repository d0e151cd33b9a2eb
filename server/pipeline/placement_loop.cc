#include "server/pipeline/placement_loop.h"

#include <absl/strings/str_join.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "core/stopwatch.h"
#include "server/match_graph/match_graph.h"

namespace isthmus::server {
namespace {

// Fills in what the spanning tree says of the sessions; its matches.
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

PlacementLoop::PlacementLoop(MapState* state, storage::MapStore* store, const Clock* clock,
                             const placement::PlacerOptions& options)
    : state_(state), store_(store), clock_(clock), placer_(options) {
  thread_ = std::thread([this] { Run(); });
}

PlacementLoop::~PlacementLoop() {
  Stop();
  thread_.join();
}

void PlacementLoop::Stop() {
  std::lock_guard lock(state_->mutex);
  stop_ = true;
  state_->changed.notify_all();
}

absl::StatusOr<std::string> PlacementLoop::WriteG2o(uint32_t component) {
  std::lock_guard lock(placer_mutex_);
  return placer_.WriteG2o(component);
}

void PlacementLoop::Run() {
  std::unique_lock lock(state_->mutex);
  while (true) {
    if (!state_->IsPlaced()) {
      Place(&lock);
    } else if (stop_) {
      break;
    } else {
      state_->changed.wait(lock);
    }
  }
  state_->placing = false;
  state_->changed.notify_all();
}

void PlacementLoop::Place(std::unique_lock<std::mutex>* lock) {
  const uint64_t version = state_->graph_version;
  const Changes changes = std::exchange(state_->changes, {});
  placement::Input input = state_->PlacementInput();
  const std::vector<match_graph::Node> nodes = state_->MatchGraphNodes();
  // Nobody else makes revisions.
  const std::vector<Placement> previous = state_->revision.placements;
  MapRevision next;
  next.revision = state_->revision.revision + 1;
  lock->unlock();

  const Stopwatch watch;
  std::vector<SessionPair> tree = PlaceByTree(nodes, previous, &input);
  placement::Outcome outcome;
  {
    std::lock_guard placing(placer_mutex_);
    outcome = placer_.Place(input, previous);
  }
  storage::WriteBatch batch;
  batch.moves = placement::FindMoves(previous, outcome.placements);
  const bool is_new = !batch.moves.empty() || !SameFrames(previous, outcome.placements);
  if (is_new && stored_) batch.moves = placement::FindMoves(*stored_, outcome.placements);
  if (is_new) {
    next.stamp_ns = clock_->NowNs();
    next.cause = absl::StrJoin(changes.causes, "; ");
    next.matches = Unique(changes.matches);
    next.loops = Unique(changes.loops);
    next.placements = std::move(outcome.placements);
    batch.revision = std::move(next);
    // Readers see the newest truth even when it cannot be stored: it follows from what is stored
    // and is found again at the next start.
    const bool is_stored = store_->Write(batch).ok();
    if (is_stored) {
      stored_.reset();
    } else if (!stored_) {
      stored_ = previous;
    }
  }
  const double ms = watch.Ms();

  lock->lock();
  if (is_new) state_->revision = *std::move(batch.revision);
  state_->tree = std::move(tree);
  state_->judgement = std::move(outcome.judgement);
  state_->placed_version = version;
  state_->placement_ms = ms;
  ++state_->placements;
  state_->changed.notify_all();
}

}  // namespace isthmus::server
