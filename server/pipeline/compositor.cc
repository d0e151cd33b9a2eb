#include "server/pipeline/compositor.h"

#include <absl/strings/str_cat.h>

#include <algorithm>
#include <chrono>
#include <set>
#include <utility>

namespace isthmus::server {
namespace {

constexpr double kComposeAgainS = 3;  // After a failure.
constexpr double kLastMapMs = 1000;   // What compositions may still take when told to stop.

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
  return composer_.Compose(revision, placed, reader_, [&](double share) {
    if (starting_ != nullptr) starting_->SetDone(share);
    return KeepsOn();
  });
}

// While no session was removed since, and the thread is not to end.
bool Compositor::KeepsOn() {
  if (removals_ && state_->removals != *removals_) return false;
  if (!stop_) return true;
  if (!since_stop_) since_stop_.emplace();
  return starting_ == nullptr && since_stop_->Ms() < kLastMapMs;
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

void Compositor::ReportLeftOut() {
  const composition::Composer::LeftOut left_out = composer_.left_out();
  const auto most = left_out.points > 0 ? std::optional(left_out.most) : std::nullopt;
  if (std::exchange(left_out_, most) == most || !most || !on_problem_) return;
  on_problem_(absl::StrCat(
      "the merged map leaves out ", left_out.points, " points, most of them of submap ",
      ToString(*most), ": they are scattered over more tiles than it may have. Delete the session ",
      "if they are noise; else raise composition.max_tiles or composition.tile_m"));
}

void Compositor::Run() {
  using SteadyClock = std::chrono::steady_clock;
  SteadyClock::time_point next_allowed = SteadyClock::now();
  bool cancelled = false;  // The last composition.
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
    removals_ = cancelled ? std::nullopt : std::optional<uint64_t>(state_->removals);
    lock.unlock();
    Stopwatch watch;
    absl::StatusOr<std::shared_ptr<const ComposedMap>> map = Compose(revision, placed);
    const double ms = watch.Ms();
    cancelled = absl::IsCancelled(map.status());
    if (!cancelled) Report(map.status());
    if (map.ok()) ReportLeftOut();
    lock.lock();
    if (map.ok()) {
      starting_ = nullptr;
      Publish(*std::move(map), ms);
    } else if (stop_) {
      return;
    }
    if (cancelled) continue;
    const double pause_s = map.ok() ? interval_s_ : kComposeAgainS;
    next_allowed = SteadyClock::now() + std::chrono::microseconds(int64_t(pause_s * 1e6));
  }
}

}  // namespace isthmus::server
