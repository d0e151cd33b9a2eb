#include "server/ingest/session_worker.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>

#include <algorithm>
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

SessionWorker::SessionWorker(const SessionRecord& record, const floam::SensorModel& sensor,
                             const Options& options, WorkerHooks hooks, Executor* executor,
                             const ResumePoint& resume)
    : record_(record),
      sensor_(sensor),
      options_(options),
      hooks_(std::move(hooks)),
      executor_(executor) {
  MutexLock lock(&mutex_);
  Resume(resume);
  checkpoint_sequence_ = last_submitted_ = status_.last_sequence;
}

absl::Status SessionWorker::Submit(ScanUpload scan) {
  if (scan.sequence == 0) {
    return absl::InvalidArgumentError("scan sequence 0 is not allowed: sequences count from 1");
  }
  bool blocked = false;
  {
    MutexLock lock(&mutex_);
    blocked = unpersisted_.size() >= kMaxUnpersisted;
  }
  if (blocked) {
    if (absl::Status stored = PersistFinished(); !stored.ok()) {
      return absl::ResourceExhaustedError(
          absl::StrCat("the server cannot store finished submaps and takes no more scans until it "
                       "can (free space on its disk, then send again): ",
                       stored.message()));
    }
  }
  MutexLock lock(&mutex_);
  while (!stopping_ && queue_.size() >= options_.queue) changed_.Wait(&mutex_);
  if (stopping_) {
    return absl::UnavailableError(absl::StrCat(
        "session ", record_.id.value(), " takes no scans at the moment: it is being closed"));
  }
  if (scan.sequence > last_submitted_ + 1) {
    return absl::OutOfRangeError(absl::StrCat("scan sequence ", scan.sequence, " leaves a gap: ",
                                              last_submitted_ + 1, " is expected next"));
  }
  // In this order because any of it may throw; the task waits for the lock.
  if (!running_) {
    executor_->Post([self = shared_from_this()] { self->RunOne(); });
    running_ = true;
  }
  const uint64_t sequence = scan.sequence;
  queue_.push_back(std::move(scan));
  last_submitted_ = std::max(last_submitted_, sequence);
  return absl::OkStatus();
}

bool SessionWorker::HasRoom() const {
  MutexLock lock(&mutex_);
  return stopping_ || queue_.size() < options_.queue;
}

void SessionWorker::SetAckSink(AckSink sink) {
  MutexLock lock(&sink_mutex_);
  sink_ = std::move(sink);
}

void SessionWorker::SendAck(const ScanAck& ack) {
  MutexLock lock(&sink_mutex_);
  if (sink_) sink_(ack);
}

void SessionWorker::RunOne() {
  std::optional<ScanUpload> scan;
  {
    MutexLock lock(&mutex_);
    if (!queue_.empty()) {
      scan = std::move(queue_.front());
      queue_.pop_front();
      changed_.SignalAll();
    }
  }
  if (scan) {
    ScanAck ack;
    ack.sequence = scan->sequence;
    try {
      HandleScan(*scan, &ack);
    } catch (...) {
      // The ack says what is known; what could not be stored is offered again.
    }
    try {
      SendAck(ack);
    } catch (...) {
      // Who takes acks has lost this one; the next says what is durable.
    }
    hooks_.scan_done();
  }
  MutexLock lock(&mutex_);
  running_ = false;
  changed_.SignalAll();
  if (queue_.empty()) return;
  executor_->Post([self = shared_from_this()] { self->RunOne(); });
  running_ = true;
}

void SessionWorker::HandleScan(const ScanUpload& upload, ScanAck* ack) {
  bool is_duplicate = false;
  {
    MutexLock lock(&mutex_);
    is_duplicate = upload.sequence <= status_.last_sequence;
    if (is_duplicate) {
      ack->outcome = ScanOutcome::kDuplicate;
      FillStatus(ack);
    } else {
      status_.last_sequence = upload.sequence;
    }
  }
  if (!is_duplicate) {
    const ScanCounts counts = state_->counts;
    try {
      DealWithAndCut(upload, ack);
    } catch (...) {
      state_->counts = counts;
      Break(CaughtStatus(), ack);
    }
    // A failure is kept for the next attempt; Submit tells the robot when it lasts.
    (void)PersistFinished();
    MutexLock lock(&mutex_);
    FillStatus(ack);
  }
  ack->T_map_odom = hooks_.T_map_odom(ack->segment);
}

void SessionWorker::DealWithAndCut(const ScanUpload& upload, ScanAck* ack) {
  if (is_broken_) BeginAnew();
  DealWith(upload, ack);
  std::deque<FinishedSubmap> finished =
      TakeFinished(upload.sequence, checkpoint_sequence_ + options_.checkpoint_scans);
  MutexLock lock(&mutex_);
  for (FinishedSubmap& submap : finished) unpersisted_.push_back(std::move(submap));
}

void SessionWorker::FillStatus(ScanAck* ack) const {
  ack->durable_sequence = status_.durable_sequence;
  ack->segment = status_.segment;
  ack->segment_session = SegmentId(record_.id, status_.segment);
  ack->lost_since_ns = status_.lost_since_ns;
  ack->scans = status_.scans;
}

absl::Status SessionWorker::Finish() {
  absl::Status cut;
  {
    MutexLock lock(&mutex_);
    stopping_ = true;
    changed_.SignalAll();
    while (running_) changed_.Wait(&mutex_);
    try {
      CutTheLast();
    } catch (...) {
      is_broken_ = true;
      cut = CaughtStatus();
    }
  }
  cut.Update(RetryStoring());
  return cut;
}

void SessionWorker::CutTheLast() {
  if (is_broken_) return;
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

void SessionWorker::Abandon() {
  size_t dropped = 0;
  {
    MutexLock lock(&mutex_);
    stopping_ = true;
    dropped = queue_.size();
    queue_.clear();
    changed_.SignalAll();
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
