#include "server/threads/composition_thread.h"

#include <absl/strings/str_cat.h>
#include <absl/time/clock.h>
#include <absl/time/time.h>

#include <algorithm>
#include <set>
#include <utility>

#include "server/threads/limits.h"

namespace isthmus::server {

CompositionThread::CompositionThread(MapWriter* map, Activity* activity, SubmapReader reader,
                                     const composition::ComposerOptions& options, double interval_s,
                                     OnProblem on_problem)
    : map_(map),
      activity_(activity),
      reader_(std::move(reader)),
      interval_s_(interval_s),
      on_problem_(std::move(on_problem)),
      composer_(options) {
  map_->ShowComposed(FirstMap());
  thread_ = std::thread([this] { Run(); });
}

CompositionThread::~CompositionThread() {
  Stop();
  thread_.join();
}

void CompositionThread::Stop() {
  stop_ = true;
  map_->changed().Notify();
}

std::shared_ptr<const ComposedMap> CompositionThread::FirstMap() {
  uint32_t components = 0;
  std::set<RobotId> robots;
  const MapWriter::View view = map_->view();
  for (const Placement& placement : view->revision->placements) {
    if (placement.submaps.empty()) continue;
    components = std::max(components, placement.component + 1);
    const SessionView* session = view->Find(placement.session);
    if (session != nullptr) robots.insert(session->record.robot);
  }
  loading_ =
      std::make_shared<LoadingMap>(std::vector<RobotId>(robots.begin(), robots.end()), components);
  if (components > 0) return loading_;
  // Nothing is stored, so there is nothing to wait for.
  auto empty = composer_.Compose(0, {}, reader_);
  if (!empty.ok()) return loading_;
  loading_ = nullptr;
  return *std::move(empty);
}

absl::StatusOr<std::shared_ptr<const ComposedMap>> CompositionThread::Compose(
    int64_t revision, const std::vector<PlacedSubmap>& placed) {
  return composer_.Compose(revision, placed, reader_, [&](double share) {
    if (loading_ != nullptr) loading_->SetDone(share);
    return KeepsOn();
  });
}

// While no session was removed since, and the thread is not to end.
bool CompositionThread::KeepsOn() {
  if (removals_ && map_->view()->removals != *removals_) return false;
  if (!stop_) return true;
  if (!since_stop_) since_stop_.emplace();
  return loading_ == nullptr && since_stop_->Ms() < kLastMapMs;
}

void CompositionThread::Report(const absl::Status& status) {
  const std::string problem(status.message());
  if (std::exchange(problem_, problem) == problem || problem.empty() || !on_problem_) return;
  on_problem_("the merged map stays as it was: " + problem);
}

void CompositionThread::ReportLeftOut() {
  const composition::Composer::LeftOut left_out = composer_.left_out();
  const auto most = left_out.points > 0 ? std::optional(left_out.most) : std::nullopt;
  if (std::exchange(left_out_, most) == most || !most || !on_problem_) return;
  on_problem_(absl::StrCat(
      "the merged map leaves out ", left_out.points, " points, most of them of submap ",
      ToString(*most), ": they are scattered over more tiles than it may have. Delete the session ",
      "if they are noise; else raise composition.max_tiles or composition.tile_m"));
}

void CompositionThread::Run() {
  absl::Time next_allowed = absl::Now();
  bool cancelled = false;  // The last composition.
  while (true) {
    const uint64_t seen = map_->changed().count();
    const MapWriter::View view = map_->view();
    if (view->IsComposed()) {
      if (stop_) return;
      map_->changed().WaitPast(seen);
      continue;
    }
    if (!stop_ && absl::Now() < next_allowed) {
      map_->changed().WaitPast(seen, next_allowed);
      continue;
    }
    removals_ = cancelled ? std::nullopt : std::optional<uint64_t>(view->removals);
    Stopwatch watch;
    auto map = Compose(view->revision->revision, view->PlacedSubmaps());
    const double ms = watch.Ms();
    cancelled = absl::IsCancelled(map.status());
    if (!cancelled) Report(map.status());
    if (map.ok()) {
      ReportLeftOut();
      loading_ = nullptr;
      activity_->Composed(ms);
      map_->ShowComposed(*std::move(map));
    } else if (stop_) {
      return;
    }
    if (cancelled) continue;
    next_allowed = absl::Now() + absl::Seconds(map.ok() ? interval_s_ : kComposeAgainS);
  }
}

}  // namespace isthmus::server
