#include "server/pipeline/compositor.h"

#include <algorithm>
#include <chrono>
#include <set>
#include <utility>

#include "core/stopwatch.h"

namespace isthmus::server {
namespace {

constexpr double kRetryS = 3;        // After a failure.
constexpr double kLastMapMs = 2000;  // What the composition under way may take when told to stop.

}  // namespace

Compositor::Compositor(MapState* state, SubmapReader reader,
                       const composition::ComposerOptions& options, double interval_s,
                       OnProblem on_problem)
    : state_(state),
      reader_(std::move(reader)),
      interval_s_(interval_s),
      on_problem_(std::move(on_problem)),
      composer_(options) {
  {
    std::lock_guard lock(state_->mutex);
    state_->map = FirstMap();
  }
  thread_ = std::thread([this] { Run(); });
}

Compositor::~Compositor() {
  Stop();
  thread_.join();
}

void Compositor::Stop() {
  std::lock_guard lock(state_->mutex);
  stop_ = true;
  state_->changed.notify_all();
}

std::shared_ptr<const ComposedMap> Compositor::FirstMap() {
  uint32_t components = 0;
  std::set<RobotId> robots;
  for (const Placement& placement : state_->revision.placements) {
    if (placement.submaps.empty()) continue;
    components = std::max(components, placement.component + 1);
    const SessionEntry* entry = state_->Find(placement.session);
    if (entry != nullptr) robots.insert(entry->record.robot);
  }
  starting_ =
      std::make_shared<StartingMap>(std::vector<RobotId>(robots.begin(), robots.end()), components);
  if (components > 0) return starting_;
  // Nothing is stored, so there is nothing to wait for.
  auto empty = composer_.Compose(0, {}, reader_);
  if (!empty.ok()) return starting_;
  starting_ = nullptr;
  return *std::move(empty);
}

absl::StatusOr<std::shared_ptr<const ComposedMap>> Compositor::Compose(
    int64_t revision, const std::vector<PlacedSubmap>& placed) {
  Stopwatch watch;
  return composer_.Compose(revision, placed, reader_, [&](double share) {
    if (starting_ != nullptr) starting_->SetDone(share);
    return !stop_ || (starting_ == nullptr && watch.Ms() < kLastMapMs);
  });
}

void Compositor::Publish(std::shared_ptr<const ComposedMap> map, double ms) {
  state_->composed_revision = map->revision();
  state_->map = std::move(map);
  state_->composition_ms = ms;
  state_->composition_max_ms = std::max(state_->composition_max_ms, ms);
  ++state_->compositions;
  state_->changed.notify_all();
}

void Compositor::Report(const absl::Status& status) {
  const std::string problem(status.message());
  if (std::exchange(problem_, problem) == problem || problem.empty() || !on_problem_) return;
  on_problem_("the merged map stays as it was: " + problem);
}

void Compositor::Run() {
  using SteadyClock = std::chrono::steady_clock;
  SteadyClock::time_point next_allowed = SteadyClock::now();
  std::unique_lock lock(state_->mutex);
  while (true) {
    if (state_->IsComposed()) {
      if (stop_) return;
      state_->changed.wait(lock);
      continue;
    }
    if (!stop_ && SteadyClock::now() < next_allowed) {
      state_->changed.wait_until(lock, next_allowed);
      continue;
    }
    const int64_t revision = state_->revision.revision;
    const std::vector<PlacedSubmap> placed = state_->PlacedSubmaps();
    lock.unlock();
    Stopwatch watch;
    absl::StatusOr<std::shared_ptr<const ComposedMap>> map = Compose(revision, placed);
    const double ms = watch.Ms();
    if (!absl::IsCancelled(map.status())) Report(map.status());
    lock.lock();
    if (map.ok()) {
      starting_ = nullptr;
      Publish(*std::move(map), ms);
    } else if (stop_) {
      return;
    }
    const double pause_s = map.ok() ? interval_s_ : kRetryS;
    next_allowed = SteadyClock::now() + std::chrono::microseconds(int64_t(pause_s * 1e6));
  }
}

}  // namespace isthmus::server
