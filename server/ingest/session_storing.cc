// The storing of submaps that are cut.
#include <algorithm>
#include <utility>

#include "core/caught.h"
#include "core/concurrency/mutex.h"
#include "server/ingest/limits.h"
#include "server/ingest/session_worker.h"

namespace isthmus::ingest {

void SessionWorker::FinishSubmap(std::shared_ptr<const Submap> submap) {
  if (submap != nullptr) state_->odometry.Remember(*submap);
  HandOverSubmap(std::move(submap));
}

void SessionWorker::HandOverSubmap(std::shared_ptr<const Submap> submap) {
  if (submap == nullptr) return;
  std::vector<TrajectoryEntry> trajectory = std::exchange(state_->unfinished, {});
  // A checkpoint may be older than the last submap: then this one was made, and stored, before.
  if (std::pair(state_->segment, submap->id.index) < stored_until_) return;
  finished_.push_back({std::move(submap), std::move(trajectory), state_->segment});
}

std::deque<FinishedSubmap> SessionWorker::TakeFinished(uint64_t sequence,
                                                       uint64_t checkpoint_after) {
  std::deque<FinishedSubmap> finished = std::exchange(finished_, {});
  if (finished.empty() && sequence < checkpoint_after && !checkpoint_due_) return finished;
  // Without memory for it the submap goes alone; the robot keeps its scans until the next one.
  absl::StatusOr<std::string> state;
  try {
    state = state_->Save();
  } catch (...) {
    state = CaughtStatus();
  }
  if (!state.ok()) return finished;
  checkpoint_sequence_ = sequence;
  checkpoint_due_ = false;
  if (finished.empty()) finished.emplace_back();
  const std::vector<TrajectoryEntry>& unfinished = state_->unfinished;
  finished.back().checkpoint = {sequence,
                                unfinished.empty() ? sequence : unfinished.front().sequence - 1,
                                *std::move(state), state_->segment};
  return finished;
}

bool SessionWorker::Cut(uint64_t sequence) {
  std::deque<FinishedSubmap> finished =
      TakeFinished(sequence, checkpoint_sequence_ + options_.checkpoint_scans);
  MutexLock lock(&mutex_);
  for (FinishedSubmap& submap : finished) unpersisted_.push_back(std::move(submap));
  return !finished.empty();
}

bool SessionWorker::PersistAsync(uint64_t sequence) {
  bool has_more = false;
  try {
    has_more = Cut(sequence);
  } catch (...) {
    is_broken_ = true;  // A submap may be gone, and the next must not follow as if it were there.
    return false;
  }
  try {
    {
      MutexLock lock(&mutex_);
      if (!has_more && !storing_fails_) return false;
      if (unpersisted_.size() < kMaxUnpersisted) {
        if (storing_posted_) return false;
        options_.storing->Post(storing_lane_, [self = shared_from_this()] { self->Store(); });
        return storing_posted_ = true;
      }
    }
    (void)RetryStoring();
  } catch (...) {
    // It is offered again after the next scan.
  }
  return false;
}

void SessionWorker::Store() {
  {
    // Submaps that are cut from now on are for the next task.
    MutexLock lock(&mutex_);
    storing_posted_ = false;
  }
  try {
    // A failure is kept for the next attempt.
    (void)RetryStoring();
  } catch (...) {
    // The sink of acks has lost this one; the next says what is durable.
  }
  hooks_.scan_done();
}

absl::Status SessionWorker::PersistFinished() {
  MutexLock persisting(&persist_mutex_);
  while (true) {
    FinishedSubmap next;
    {
      MutexLock lock(&mutex_);
      if (unpersisted_.empty()) return absl::OkStatus();
      next = unpersisted_.front();
    }
    absl::Status status;
    try {
      status = hooks_.persist(next);
    } catch (...) {
      status = CaughtStatus();
    }
    MutexLock lock(&mutex_);
    storing_fails_ = !status.ok();
    if (storing_fails_) return status;
    unpersisted_.pop_front();
    if (next.checkpoint) {
      status_.durable_sequence = next.checkpoint->durable_sequence;
      ForgetTimes();
    }
    if (next.submap == nullptr) continue;
    std::erase_if(status_.unsaved[next.segment], [&](const TrajectoryEntry& entry) {
      return entry.sequence <= next.submap->last_sequence;
    });
  }
}

void SessionWorker::ForgetTimes() {
  const int64_t now_ns = options_.clock->NowNs();
  times_.ForgetUpTo(status_.durable_sequence, [&](int64_t came_ns) {
    if (options_.observer == nullptr) return;
    // A clock that was set back makes nothing durable before it came.
    const int64_t waited_ns = std::max<int64_t>(now_ns - came_ns, 0);
    options_.observer->NoteStage(Stage::kDurable, 1e-9 * static_cast<double>(waited_ns));
  });
}

}  // namespace isthmus::ingest
