// From submaps that are cut to what is stored.
#include <algorithm>
#include <utility>

#include "core/caught.h"
#include "core/concurrency/mutex.h"
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
    if (!status.ok()) return status;
    MutexLock lock(&mutex_);
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
