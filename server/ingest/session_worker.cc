#include "server/ingest/session_worker.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>

#include <algorithm>
#include <utility>

namespace isthmus::ingest {
namespace {

// Finished submaps and checkpoints that may wait for the store (a full disk) before scans are
// refused.
constexpr size_t kMaxUnpersisted = 2;
// Scans in a row that cannot be used, after which a submap ends: the odometry bridges fewer.
constexpr int kBlindScans = 3;
// So many lost scans in a row are worth a line in the log.
constexpr uint32_t kLostScans = 3;

std::string ToString(floam::TrackingStatus status) {
  switch (status) {
    case floam::TrackingStatus::kOk:
      return "ok";
    case floam::TrackingStatus::kDegenerate:
      return "degenerate";
    case floam::TrackingStatus::kLost:
      return "lost";
  }
  return "unknown";
}

std::string InputText(const codec::ScanFields& fields, const floam::OdometryResult& result) {
  const auto given = [](floam::Inference from, const std::string& field) {
    return from == floam::Inference::kSensor ? absl::StrCat(" by ", field) : std::string();
  };
  const std::string& warning = result.input.warning;
  return absl::StrCat("rings: ", result.input.rings, given(result.rings_from, fields.ring),
                      "; times: ", result.input.times, given(result.times_from, fields.time),
                      warning.empty() ? "" : "; is the sensor's name right? ", warning);
}

}  // namespace

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
  Resume(resume);
  checkpoint_sequence_ = last_submitted_ = status_.last_sequence;
}

void SessionWorker::MakeState(uint32_t segment, uint32_t first_index) {
  state_ = std::make_unique<SessionState>(record_, sensor_, options_.odometry, options_.submap,
                                          segment, first_index);
}

void SessionWorker::Remember(const ResumePoint& resume, Cloud* around) {
  const auto stored =
      std::find_if(resume.segments.begin(), resume.segments.end(),
                   [this](const auto& segment) { return segment.segment == state_->segment; });
  if (stored == resume.segments.end() || !stored->for_each_submap) return;
  stored->for_each_submap([&](const Submap& submap) {
    state_->odometry.Remember(submap);
    if (around == nullptr || !T_odom_last_) return;
    for (const SubmapPoint& point : submap.points) {
      const Eigen::Vector3d p = submap.T_odom_submap * point.Position().cast<double>();
      if ((p - T_odom_last_->translation()).norm() > options_.odometry.map.radius_m) continue;
      const Eigen::Vector3f q = p.cast<float>();
      around->push_back({q.x(), q.y(), q.z(), point.intensity});
    }
  });
}

void SessionWorker::Resume(const ResumePoint& resume) {
  for (const StoredSegment& segment : resume.segments) {
    T_odom_last_.reset();  // No way leads from one segment to the next.
    for (const TrajectoryEntry& entry : segment.trajectory) Follow(entry);
    stored_until_ = {segment.segment, segment.next_index};
  }
  const std::optional<Checkpoint>& checkpoint = resume.checkpoint;
  absl::Status usable = absl::DataLossError("the checkpoint is damaged");
  if (checkpoint && checkpoint->state) {
    MakeState(1, 0);
    usable = state_->Restore(*checkpoint->state, [&] { Remember(resume, nullptr); });
  }
  if (!usable.ok()) {
    ResumeFromSubmaps(resume);
    status_.segment = state_->segment;
    if (!checkpoint) return;
    status_.resumed = absl::StrCat("resumed from submaps: ", usable.message());
    status_.input = status_.resumed;
    return;
  }
  if (state_->segment != stored_until_.first) T_odom_last_.reset();
  status_.last_sequence = checkpoint->sequence;
  status_.durable_sequence = checkpoint->durable_sequence;
  status_.segment = state_->segment;
  status_.scans = state_->counts;
  status_.lost_since_ns = state_->lost_since_ns;
  status_.unsaved[state_->segment] = state_->stretch;
  for (const TrajectoryEntry& entry : state_->stretch) Follow(entry);
}

void SessionWorker::ResumeFromSubmaps(const ResumePoint& resume) {
  StoredSegment last;
  for (const StoredSegment& segment : resume.segments) {
    const uint64_t stored = std::max(last.last_sequence, segment.last_sequence);
    last = segment;
    last.last_sequence = stored;
  }
  // Numbers that cannot be are not believed.
  const std::optional<Checkpoint>& checkpoint = resume.checkpoint;
  const bool counts = checkpoint && checkpoint->durable_sequence >= last.last_sequence &&
                      checkpoint->durable_sequence <= checkpoint->sequence;
  status_.last_sequence = counts ? checkpoint->durable_sequence : last.last_sequence;
  status_.durable_sequence = status_.last_sequence;
  if (last.trajectory.empty()) {
    // Whatever the robot was told of this segment's frame, nothing is left that says where it was.
    const bool is_new = status_.last_sequence > 0;
    MakeState(is_new ? last.segment + 1 : last.segment, is_new ? 0 : last.next_index);
    checkpoint_due_ = is_new;
    return;
  }
  MakeState(last.segment, last.next_index);
  Cloud around;
  Remember(resume, &around);
  Trajectory recent;
  for (const TrajectoryEntry& entry : last.trajectory) {
    recent.push_back({entry.stamp_ns, entry.T_odom_sensor});
  }
  state_->clock.Advance(recent.back().stamp_ns, recent.back().stamp_ns);
  state_->odometry.Resume(around, recent);
}

// Takes note of where the robot was.
void SessionWorker::Follow(const TrajectoryEntry& entry) {
  if (T_odom_last_) {
    status_.travelled_m += (entry.T_odom_sensor.translation() - T_odom_last_->translation()).norm();
  }
  T_odom_last_ = entry.T_odom_sensor;
}

absl::Status SessionWorker::Submit(ScanUpload scan) {
  if (scan.sequence == 0) {
    return absl::InvalidArgumentError("scan sequence 0 is not allowed: sequences count from 1");
  }
  bool blocked = false;
  {
    std::lock_guard lock(mutex_);
    blocked = unpersisted_.size() >= kMaxUnpersisted;
  }
  if (blocked) {
    if (absl::Status stored = Persist(); !stored.ok()) {
      return absl::ResourceExhaustedError(
          absl::StrCat("the server cannot store finished submaps and takes no more scans until it "
                       "can (free space on its disk, then send again): ",
                       stored.message()));
    }
  }
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [this] { return stopping_ || queue_.size() < options_.queue; });
  if (stopping_) {
    return absl::UnavailableError(absl::StrCat(
        "session ", record_.id.value(), " takes no scans at the moment: it is being closed"));
  }
  if (scan.sequence > last_submitted_ + 1) {
    return absl::OutOfRangeError(absl::StrCat("scan sequence ", scan.sequence, " leaves a gap: ",
                                              last_submitted_ + 1, " is expected next"));
  }
  last_submitted_ = std::max(last_submitted_, scan.sequence);
  queue_.push_back(std::move(scan));
  if (!running_) {
    running_ = true;
    executor_->Post([self = shared_from_this()] { self->RunOne(); });
  }
  return absl::OkStatus();
}

void SessionWorker::SetAckSink(AckSink sink) {
  std::lock_guard lock(sink_mutex_);
  sink_ = std::move(sink);
}

void SessionWorker::Send(const ScanAck& ack) {
  std::lock_guard lock(sink_mutex_);
  if (sink_) sink_(ack);
}

void SessionWorker::RunOne() {
  std::optional<ScanUpload> scan;
  {
    std::lock_guard lock(mutex_);
    if (!queue_.empty()) {
      scan = std::move(queue_.front());
      queue_.pop_front();
      changed_.notify_all();
    }
  }
  if (scan) {
    Send(Handle(*scan));
    hooks_.scan_done();
  }
  std::lock_guard lock(mutex_);
  running_ = !queue_.empty();
  if (running_) executor_->Post([self = shared_from_this()] { self->RunOne(); });
  changed_.notify_all();
}

ScanAck SessionWorker::Handle(const ScanUpload& upload) {
  ScanAck ack;
  ack.sequence = upload.sequence;
  bool is_duplicate = false;
  {
    std::lock_guard lock(mutex_);
    is_duplicate = upload.sequence <= status_.last_sequence;
    if (is_duplicate) {
      ack.outcome = ScanOutcome::kDuplicate;
      FillStatus(&ack);
    } else {
      status_.last_sequence = upload.sequence;
    }
  }
  if (is_duplicate) {
    ack.T_map_odom = hooks_.T_map_odom(ack.segment);
    return ack;
  }
  DealWith(upload, &ack);
  std::deque<Stretch> finished =
      TakeFinished(upload.sequence, checkpoint_sequence_ + options_.checkpoint_scans);
  {
    std::lock_guard lock(mutex_);
    for (Stretch& stretch : finished) unpersisted_.push_back(std::move(stretch));
  }
  // A failure is kept for the next attempt; Submit tells the robot when it lasts.
  (void)Persist();
  {
    std::lock_guard lock(mutex_);
    FillStatus(&ack);
  }
  ack.T_map_odom = hooks_.T_map_odom(ack.segment);
  return ack;
}

void SessionWorker::FillStatus(ScanAck* ack) const {
  ack->durable_sequence = status_.durable_sequence;
  ack->segment = status_.segment;
  ack->segment_session = SegmentId(record_.id, status_.segment);
  ack->lost_since_ns = status_.lost_since_ns;
  ack->scans = status_.scans;
}

void SessionWorker::DealWith(const ScanUpload& upload, ScanAck* ack) {
  const absl::StatusOr<ScanClock::Reading> reading = state_->clock.Read(upload.end_stamp_ns);
  if (!reading.ok()) {
    ack->outcome = ScanOutcome::kRejected;
    ack->reason = std::string(reading.status().message());
    ++state_->counts.rejected;
    std::lock_guard lock(mutex_);
    ++status_.rejected;
    status_.scans = state_->counts;
    return;
  }
  absl::StatusOr<floam::OdometryResult> result = Track(upload, reading->time_ns);
  if (result.ok()) {
    state_->clock.Advance(upload.end_stamp_ns, reading->time_ns);
    if (result->segment != state_->odometry_segment) BeginSegment(*result);
    if (reading->stepped) Cut(state_->builder->Finish());
    Take(*result, ack);
  } else {
    Reject(upload, result.status(), ack);
  }
}

void SessionWorker::BeginSegment(const floam::OdometryResult& first) {
  // The odometry has forgotten the old segment, and must not be told of it again.
  Hand(state_->builder->Finish());
  state_->odometry_segment = first.segment;
  state_->BeginSegment();
  checkpoint_due_ = true;
  const double lost_s =
      std::max(1e-9 * static_cast<double>(first.stamp_ns - state_->lost_since_ns), 0.0);
  Tell(absl::StrCat(
      "goes on in segment ", state_->segment, " (", SegmentId(record_.id, state_->segment).value(),
      ") from scan ", first.sequence, " on",
      state_->lost_scans == 0 ? ""
                              : absl::StrFormat(", having been lost for %d scans, %.1f s",
                                                state_->lost_scans, lost_s)));
  state_->lost_scans = 0;  // That it is found is said.
  std::lock_guard lock(mutex_);
  status_.segment = state_->segment;
  T_odom_last_.reset();
}

void SessionWorker::Tell(const std::string& what) const {
  if (!hooks_.tell) return;
  const ScanCounts& scans = state_->counts;
  hooks_.tell(absl::StrFormat(
      "session %s %s (scans so far: %d ok, %d degenerate, %d lost, %d "
      "rejected)",
      record_.id.value(), what, scans.ok, scans.degenerate, scans.lost, scans.rejected));
}

void SessionWorker::NoteTracking(bool is_lost, uint64_t sequence, int64_t stamp_ns) {
  const uint32_t lost_scans = state_->lost_scans;
  if (is_lost) {
    if (lost_scans == 0) state_->lost_since_ns = stamp_ns;
    if (++state_->lost_scans == kLostScans) {
      Tell(absl::StrCat("is lost since scan ", sequence + 1 - kLostScans, ", in segment ",
                        state_->segment));
    }
    return;
  }
  state_->lost_since_ns = 0;
  state_->lost_scans = 0;
  if (lost_scans < kLostScans) return;
  Tell(absl::StrCat("was found again with scan ", sequence, " after ", lost_scans,
                    " lost ones, in segment ", state_->segment));
}

// The odometry sees times that go forward; what leaves it bears the robot's stamps.
absl::StatusOr<floam::OdometryResult> SessionWorker::Track(const ScanUpload& upload,
                                                           int64_t time_ns) {
  absl::StatusOr<Scan> scan =
      state_->decoder.Decode(upload.payload, upload.sequence, upload.end_stamp_ns);
  if (!scan.ok()) return scan.status();
  scan->end_stamp_ns = time_ns;
  absl::StatusOr<floam::OdometryResult> result = state_->odometry.Process(*scan);
  if (result.ok()) result->stamp_ns = upload.end_stamp_ns;
  return result;
}

void SessionWorker::Reject(const ScanUpload& scan, const absl::Status& why, ScanAck* ack) {
  ack->outcome = ScanOutcome::kRejected;
  ack->reason = std::string(why.message());
  ack->status = ToString(floam::TrackingStatus::kLost);
  ++state_->counts.rejected;
  if (++state_->blind_scans == kBlindScans) Cut(state_->builder->Finish());
  const bool has_begun = state_->segment > 1 || T_odom_last_.has_value();
  if (has_begun) NoteTracking(true, scan.sequence, scan.end_stamp_ns);
  std::lock_guard lock(mutex_);
  ++status_.rejected;
  status_.scans = state_->counts;
  status_.lost_since_ns = state_->lost_since_ns;
  if (has_begun) {
    status_.tracking = ack->status;
  } else {
    status_.input = absl::StrCat("no scan could be used so far: ", ack->reason);
  }
}

void SessionWorker::Take(const floam::OdometryResult& result, ScanAck* ack) {
  state_->blind_scans = 0;
  const bool lost = result.status == floam::TrackingStatus::kLost;
  if (lost) Cut(state_->builder->Finish());
  const TrajectoryEntry entry{result.sequence, result.stamp_ns, result.T_odom_sensor,
                              state_->builder->CurrentIndex()};
  if (!lost) state_->stretch.push_back(entry);
  Cut(state_->builder->Add(result));
  ScanCounts& scans = state_->counts;
  ++(lost                                                  ? scans.lost
     : result.status == floam::TrackingStatus::kDegenerate ? scans.degenerate
                                                           : scans.ok);
  NoteTracking(lost, result.sequence, result.stamp_ns);

  ack->status = ToString(result.status);
  ack->T_odom_sensor = result.T_odom_sensor;
  ack->covariance = result.covariance;
  ack->unobserved_translations = result.degeneracy.translations;
  ack->unobserved_rotations = result.degeneracy.rotations;
  ack->features_ms = result.timing.features_ms;
  ack->matching_ms = result.timing.matching_ms;
  ack->map_ms = result.timing.map_ms;
  ack->total_ms = result.timing.total_ms;

  std::lock_guard lock(mutex_);
  ++status_.processed;
  odometry_ms_sum_ += result.timing.total_ms;
  status_.odometry_ms_mean = odometry_ms_sum_ / static_cast<double>(status_.processed);
  status_.tracking = ack->status;
  status_.scans = scans;
  status_.lost_since_ns = state_->lost_since_ns;
  status_.input = InputText(state_->decoder.fields(), result);
  if (!status_.resumed.empty()) absl::StrAppend(&status_.input, "; ", status_.resumed);
  if (lost) return;
  Follow(entry);
  status_.unsaved[state_->segment].push_back(entry);
}

void SessionWorker::Cut(std::shared_ptr<const Submap> submap) {
  if (submap != nullptr) state_->odometry.Remember(*submap);
  Hand(std::move(submap));
}

void SessionWorker::Hand(std::shared_ptr<const Submap> submap) {
  if (submap == nullptr) return;
  std::vector<TrajectoryEntry> trajectory = std::exchange(state_->stretch, {});
  // A checkpoint may be older than the last submap: then this one was made, and stored, before.
  if (std::pair(state_->segment, submap->id.index) < stored_until_) return;
  finished_.push_back({std::move(submap), std::move(trajectory), state_->segment});
}

std::deque<Stretch> SessionWorker::TakeFinished(uint64_t sequence, uint64_t checkpoint_after) {
  std::deque<Stretch> finished = std::exchange(finished_, {});
  if (finished.empty() && sequence < checkpoint_after && !checkpoint_due_) return finished;
  // Without memory for it the submap goes alone; the robot keeps its scans until the next one.
  absl::StatusOr<std::string> state = state_->Save();
  if (!state.ok()) return finished;
  checkpoint_sequence_ = sequence;
  checkpoint_due_ = false;
  if (finished.empty()) finished.emplace_back();
  const std::vector<TrajectoryEntry>& unfinished = state_->stretch;
  finished.back().checkpoint = {sequence,
                                unfinished.empty() ? sequence : unfinished.front().sequence - 1,
                                *std::move(state), state_->segment};
  return finished;
}

absl::Status SessionWorker::Persist() {
  std::lock_guard persisting(persist_mutex_);
  while (true) {
    Stretch next;
    {
      std::lock_guard lock(mutex_);
      if (unpersisted_.empty()) return absl::OkStatus();
      next = unpersisted_.front();
    }
    if (absl::Status status = hooks_.persist(next); !status.ok()) return status;
    std::lock_guard lock(mutex_);
    unpersisted_.pop_front();
    if (next.checkpoint) status_.durable_sequence = next.checkpoint->durable_sequence;
    if (next.submap == nullptr) continue;
    std::erase_if(status_.unsaved[next.segment], [&](const TrajectoryEntry& entry) {
      return entry.sequence <= next.submap->last_sequence;
    });
  }
}

absl::Status SessionWorker::Finish() {
  {
    std::unique_lock lock(mutex_);
    stopping_ = true;
    changed_.notify_all();
    changed_.wait(lock, [this] { return !running_; });
    Cut(state_->builder->Finish());
    for (Stretch& stretch : TakeFinished(status_.last_sequence, checkpoint_sequence_ + 1)) {
      unpersisted_.push_back(std::move(stretch));
    }
  }
  return RetryStoring();
}

absl::Status SessionWorker::RetryStoring() {
  if (absl::Status status = Persist(); !status.ok()) return status;
  ScanAck durable;
  {
    std::lock_guard lock(mutex_);
    FillStatus(&durable);
  }
  Send(durable);
  return absl::OkStatus();
}

void SessionWorker::Abandon() {
  size_t dropped = 0;
  {
    std::unique_lock lock(mutex_);
    stopping_ = true;
    dropped = queue_.size();
    queue_.clear();
    changed_.notify_all();
    changed_.wait(lock, [this] { return !running_; });
  }
  {
    // A Submit or Finish elsewhere may be storing the first of them.
    std::scoped_lock lock(persist_mutex_, mutex_);
    unpersisted_.clear();
  }
  for (size_t i = 0; i < dropped; ++i) hooks_.scan_done();
  SetAckSink(nullptr);
}

uint64_t SessionWorker::last_sequence() const {
  std::lock_guard lock(mutex_);
  return status_.last_sequence;
}

WorkerStatus SessionWorker::Status() const {
  std::lock_guard lock(mutex_);
  return status_;
}

}  // namespace isthmus::ingest
