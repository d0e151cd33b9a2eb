#include "server/ingest/session_worker.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>

#include <algorithm>
#include <chrono>
#include <utility>

#include "core/caught.h"
#include "core/concurrency/mutex.h"
#include "server/ingest/limits.h"

namespace isthmus::ingest {

std::shared_ptr<SessionWorker> SessionWorker::Create(const SessionRecord& record,
                                                     const floam::SensorModel& sensor,
                                                     const Options& options, WorkerHooks hooks,
                                                     Executor* executor,
                                                     const ResumePoint& resume) {
  return std::shared_ptr<SessionWorker>(
      new SessionWorker(record, sensor, options, std::move(hooks), executor, resume));
}

namespace {

SessionWorker::Options Completed(SessionWorker::Options options, WhenBehind when_behind) {
  if (when_behind == WhenBehind::kKeepNewest) {
    options.queue = std::min(options.queue, kNewestWaiting);
  }
  if (options.room == nullptr) options.room = std::make_shared<QueueRoom>(~size_t{0} / 2);
  if (!options.now_ns) {
    options.now_ns = [] {
      return std::chrono::nanoseconds(std::chrono::steady_clock::now().time_since_epoch()).count();
    };
  }
  return options;
}

}  // namespace

SessionWorker::SessionWorker(const SessionRecord& record, const floam::SensorModel& sensor,
                             const Options& options, WorkerHooks hooks, Executor* executor,
                             const ResumePoint& resume)
    : record_(record),
      sensor_(sensor),
      options_(Completed(options, record.when_behind)),
      hooks_(std::move(hooks)),
      executor_(executor),
      rate_(options_.max_rate_hz) {
  MutexLock lock(&mutex_);
  const bool is_new = !resume.checkpoint && std::ranges::all_of(resume.segments, [](const auto& s) {
    return s.segment == 1 && s.next_index == 0 && s.last_sequence == 0 && s.trajectory.empty();
  });
  if (!is_new) Resume(resume);
  checkpoint_sequence_ = last_submitted_ = acknowledged_ = status_.last_sequence;
}

absl::Status SessionWorker::CheckStoring() {
  {
    MutexLock lock(&mutex_);
    if (!storing_fails_ || unpersisted_.size() < kMaxUnpersisted) return absl::OkStatus();
  }
  const absl::Status stored = PersistFinished();
  if (stored.ok()) return absl::OkStatus();
  return absl::ResourceExhaustedError(
      absl::StrCat("the server cannot store finished submaps and takes no more scans until it can "
                   "(free space on its disk, or mend the way to its bucket or database, then send "
                   "again): ",
                   stored.message()));
}

absl::StatusOr<bool> SessionWorker::Admit(ScanUpload* scan, bool waits) {
  const uint64_t sequence = scan->sequence;
  if (sequence == 0) {
    return absl::InvalidArgumentError("scan sequence 0 is not allowed: sequences count from 1");
  }
  if (absl::Status status = CheckStoring(); !status.ok()) return status;
  if (scan->arrived_ns == 0) scan->arrived_ns = options_.now_ns();
  WaitingScan waiting = Examine(std::move(*scan));
  while (true) {
    const uint64_t freed = options_.room->freed().count();
    {
      MutexLock lock(&mutex_);
      const absl::StatusOr<bool> has_room = MakeRoom(waiting, waits);
      if (!has_room.ok()) return has_room;
      if (*has_room && sequence > last_submitted_ + 1) {
        return absl::OutOfRangeError(absl::StrCat("scan sequence ", sequence, " leaves a gap: ",
                                                  last_submitted_ + 1, " is expected next"));
      }
      if (*has_room && TakeSharedRoom(&waiting)) {
        Enqueue(std::move(waiting));
        return true;
      }
    }
    if (!waits) break;
    options_.room->freed().WaitPast(freed);
  }
  *scan = std::move(waiting.scan);
  return false;
}

void SessionWorker::SetAckSink(AckSink sink) {
  MutexLock lock(&sink_mutex_);
  sink_ = std::move(sink);
}

void SessionWorker::SendAck(ScanAck ack) {
  MutexLock lock(&sink_mutex_);
  durable_told_ = ack.durable_sequence = std::max(ack.durable_sequence, durable_told_);
  if (sink_) sink_(ack);
}

void SessionWorker::RunOne() {
  WaitingScan next;
  for (bool goes_on = true; goes_on && TakeScan(&next); goes_on = next.is_skipped) {
    ScanAck ack;
    ack.sequence = next.scan.sequence;
    bool stores_later = false;
    try {
      stores_later = HandleScan(next, &ack);
    } catch (...) {
      // The ack says what is known; what could not be stored is offered again.
      if (state_ == nullptr) {
        ack.outcome = ScanOutcome::kRejected;
        ack.reason = std::string(CaughtStatus().message());
      }
    }
    options_.room->Give(next.bytes());
    try {
      SendAck(ack);
    } catch (...) {
      // The sink of acks has lost this one; the next says what is durable.
    }
    NoteAcknowledged(next);
    TellAcknowledged(next.scan, ack.outcome);
    if (!stores_later || !PersistAsync(next.scan.sequence)) hooks_.scan_done();
  }
  MutexLock lock(&mutex_);
  running_ = false;
  changed_.SignalAll();
  if (queue_.empty()) return;
  executor_->Post(lane_, [self = shared_from_this()] { self->RunOne(); });
  running_ = true;
}

bool SessionWorker::HandleScan(const WaitingScan& waiting, ScanAck* ack) {
  const ScanUpload& upload = waiting.scan;
  bool is_new = false, stores_later = false;
  {
    MutexLock lock(&mutex_);
    if (state_ == nullptr) MakeState(1, 0);
    is_new = upload.sequence > status_.last_sequence;
    if (is_new) status_.last_sequence = upload.sequence;
    if (!is_new) ack->outcome = ScanOutcome::kDuplicate;
    if (is_new && waiting.is_skipped) SkipScan(ack);
    if (!is_new || waiting.is_skipped) FillStatus(ack);
  }
  if (is_new && !waiting.is_skipped) {
    const ScanCounts counts = state_->counts;
    try {
      if (is_broken_) RestartSegment();
      ProcessScan(waiting, ack);
      stores_later = !StoresFirst();
      if (!stores_later) (void)Cut(upload.sequence);
    } catch (...) {
      state_->counts = counts;
      MarkBroken(CaughtStatus(), ack);
    }
    // A failure is kept for the next attempt; Submit tells the robot when it lasts.
    if (!stores_later) (void)PersistFinished();
    MutexLock lock(&mutex_);
    FillStatus(ack);
  }
  ack->T_map_odom = hooks_.T_map_odom(ack->segment);
  return stores_later;
}

void SessionWorker::SkipScan(ScanAck* ack) {
  ack->outcome = ScanOutcome::kSkipped;
  ack->reason =
      "newer scans came while this one waited, or more than ingest.max_scan_rate_hz allows: the "
      "session keeps the newest";
  ++state_->counts.skipped;
  status_.scans = state_->counts;
}

void SessionWorker::FillStatus(ScanAck* ack) const {
  ack->durable_sequence = status_.durable_sequence;
  ack->segment = status_.segment;
  ack->segment_session = SegmentId(record_.id, status_.segment);
  ack->lost_since_ns = status_.lost_since_ns;
  ack->scans = status_.scans;
}

void SessionWorker::TellAcknowledged(const ScanUpload& scan, ScanOutcome outcome) const {
  if (options_.observer == nullptr) return;
  const int64_t waited_ns = options_.now_ns() - scan.arrived_ns;
  options_.observer->NoteStage(Stage::kAcknowledge, 1e-9 * static_cast<double>(waited_ns));
  options_.observer->NoteScan(record_.robot, outcome);
}

absl::Status SessionWorker::Finish() {
  absl::Status cut;
  {
    MutexLock lock(&mutex_);
    stopping_ = true;
    changed_.SignalAll();
    options_.room->freed().Notify();
    while (running_) changed_.Wait(&mutex_);
    try {
      FlushSubmap();
    } catch (...) {
      is_broken_ = true;
      cut = CaughtStatus();
    }
  }
  cut.Update(RetryStoring());
  return cut;
}

void SessionWorker::FlushSubmap() {
  if (is_broken_ || state_ == nullptr) return;
  FinishSubmap(state_->builder->Finish());
  for (FinishedSubmap& submap : TakeFinished(status_.last_sequence, checkpoint_sequence_ + 1)) {
    unpersisted_.push_back(std::move(submap));
  }
}

absl::Status SessionWorker::RetryStoring() {
  if (absl::Status status = PersistFinished(); !status.ok()) return status;
  ScanAck durable;
  {
    MutexLock lock(&mutex_);
    FillStatus(&durable);
  }
  SendAck(durable);
  return absl::OkStatus();
}

void SessionWorker::StopTaking() {
  size_t dropped = 0;
  {
    MutexLock lock(&mutex_);
    stopping_ = true;
    dropped = ClearQueue();
  }
  for (size_t i = 0; i < dropped; ++i) hooks_.scan_done();
}

void SessionWorker::Abandon() {
  size_t dropped = 0;
  {
    MutexLock lock(&mutex_);
    stopping_ = true;
    dropped = ClearQueue();
    while (running_) changed_.Wait(&mutex_);
  }
  {
    // A Submit or Finish elsewhere may be storing the first of them.
    MutexLock persisting(&persist_mutex_);
    MutexLock lock(&mutex_);
    unpersisted_.clear();
  }
  for (size_t i = 0; i < dropped; ++i) hooks_.scan_done();
  SetAckSink(nullptr);
}

uint64_t SessionWorker::last_sequence() const {
  MutexLock lock(&mutex_);
  return status_.last_sequence;
}

WorkerStatus SessionWorker::Status() const {
  MutexLock lock(&mutex_);
  return status_;
}

}  // namespace isthmus::ingest
