#include "server/map/activity.h"

#include <algorithm>
#include <utility>

#include "core/concurrency/mutex.h"

namespace isthmus::server {

Activity::Counters Activity::counters() const {
  MutexLock lock(&mutex_);
  return counters_;
}

void Activity::ScanQueued() {
  MutexLock lock(&mutex_);
  ++counters_.pending_scans;
}

void Activity::ScanDone() {
  {
    MutexLock lock(&mutex_);
    if (--counters_.pending_scans > 0) return;
  }
  changed_.Notify();
}

void Activity::NoteStage(Stage stage, double ms) const {
  if (observer_ != nullptr) observer_->NoteStage(stage, 1e-3 * ms);
}

void Activity::NoteComposition(double ms) {
  NoteStage(Stage::kComposition, ms);
  MutexLock lock(&mutex_);
  counters_.composition_ms = ms;
  counters_.composition_max_ms = std::max(counters_.composition_max_ms, ms);
  ++counters_.compositions;
}

void Activity::NotePlacement(double ms) {
  NoteStage(Stage::kPlacement, ms);
  MutexLock lock(&mutex_);
  counters_.placement_ms = ms;
  ++counters_.placements;
}

void Activity::NoteEstimation(double ms) {
  MutexLock lock(&mutex_);
  counters_.estimation_ms = ms;
  ++counters_.estimations;
}

void Activity::NoteDamage(const SubmapId& submap, const std::string& problem) {
  MutexLock lock(&mutex_);
  damaged_[submap] = problem;
}

void Activity::ForgetDamage(const std::function<bool(const SubmapId&)>& is_gone) {
  MutexLock lock(&mutex_);
  std::erase_if(damaged_, [&](const auto& item) { return is_gone(item.first); });
}

std::vector<std::string> Activity::damage() const {
  MutexLock lock(&mutex_);
  std::vector<std::string> problems;
  for (const auto& [id, problem] : damaged_) problems.push_back(problem);
  return problems;
}

void Activity::NoteAwaited(std::string why) {
  MutexLock lock(&mutex_);
  awaited_ = std::move(why);
}

std::string Activity::awaited() const {
  MutexLock lock(&mutex_);
  return awaited_;
}

}  // namespace isthmus::server
