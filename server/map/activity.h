// The server's activity: the work under way, its times, and the records that cannot be read. None
// of it is part of the map.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "core/concurrency/event_count.h"
#include "core/concurrency/mutex.h"
#include "core/ids.h"
#include "core/stage_observer.h"

namespace isthmus::server {

// Thread safe.
class Activity {
 public:
  struct Counters {
    uint64_t pending_scans = 0;  // Queued or at work.
    // Last of each, and the longest; wall time.
    double composition_ms = 0, composition_max_ms = 0, estimation_ms = 0, placement_ms = 0;
    uint64_t compositions = 0, estimations = 0, placements = 0;
  };
  // The observer may be null; it must outlive this.
  explicit Activity(StageObserver* observer = nullptr) : observer_(observer) {}

  Counters counters() const;
  // May be null.
  StageObserver* observer() const { return observer_; }

  void ScanQueued();
  void ScanDone();
  void NoteComposition(double ms);
  void NotePlacement(double ms);
  void NoteEstimation(double ms);

  // Submaps that cannot be read, and why.
  void NoteDamage(const SubmapId& submap, const std::string& problem);
  void ForgetDamage(const std::function<bool(const SubmapId&)>& is_gone);
  std::vector<std::string> damage() const;  // In order of submap.

  // Why the merged map waits for the store; empty: it does not.
  void NoteAwaited(std::string why);
  std::string awaited() const;

  // Notified when the map changes, no scan is pending any more, or a thread has nothing left to do.
  EventCount& changed() { return changed_; }

 private:
  void NoteStage(Stage stage, double ms) const;

  StageObserver* const observer_;
  EventCount changed_;
  mutable Mutex mutex_;
  Counters counters_ ABSL_GUARDED_BY(mutex_);
  std::map<SubmapId, std::string> damaged_ ABSL_GUARDED_BY(mutex_);
  std::string awaited_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace isthmus::server
