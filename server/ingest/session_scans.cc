// Handling of one scan.
#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>

#include <algorithm>
#include <utility>

#include "core/concurrency/mutex.h"
#include "server/ingest/limits.h"
#include "server/ingest/session_worker.h"
#include "server/ingest/thin_scan.h"

namespace isthmus::ingest {
namespace {

Tracking TrackingOf(floam::TrackingStatus status) {
  switch (status) {
    case floam::TrackingStatus::kOk:
      return Tracking::kOk;
    case floam::TrackingStatus::kDegenerate:
      return Tracking::kDegenerate;
    case floam::TrackingStatus::kLost:
      return Tracking::kLost;
  }
  return Tracking::kUnknown;
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

void SessionWorker::ProcessScan(const WaitingScan& waiting, ScanAck* ack) {
  const ScanUpload& upload = waiting.scan;
  const absl::StatusOr<ScanClock::Reading> reading = state_->clock.Read(upload.end_stamp_ns);
  if (!reading.ok()) {
    ack->outcome = ScanOutcome::kRejected;
    ack->reason = std::string(reading.status().message());
    ++state_->counts.rejected;
    MutexLock lock(&mutex_);
    ++status_.rejected;
    status_.scans = state_->counts;
    return;
  }
  absl::StatusOr<floam::OdometryResult> result = TrackScan(waiting, reading->time_ns);
  if (result.ok()) {
    state_->clock.Advance(upload.end_stamp_ns, reading->time_ns);
    if (result->segment != state_->odometry_segment) BeginSegment(*result);
    if (reading->stepped) FinishSubmap(state_->builder->Finish());
    TakeResult(*result, ack);
  } else {
    RejectScan(upload, result.status(), ack);
  }
}

void SessionWorker::BeginSegment(const floam::OdometryResult& first) {
  // The odometry has forgotten the old segment, and must not be told of it again.
  HandOverSubmap(state_->builder->Finish());
  state_->odometry_segment = first.segment;
  state_->BeginSegment();
  checkpoint_due_ = true;
  const double lost_s =
      std::max(1e-9 * static_cast<double>(first.stamp_ns - state_->lost_since_ns), 0.0);
  Report(EventKind::kSegmentBegun,
         absl::StrCat(
             "goes on in segment ", state_->segment, " (",
             SegmentId(record_.id, state_->segment).value(), ") from scan ", first.sequence, " on",
             state_->lost_scans == 0 ? ""
                                     : absl::StrFormat(", having been lost for %d scans, %.1f s",
                                                       state_->lost_scans, lost_s)));
  state_->lost_scans = 0;  // The event has told of them.
  MutexLock lock(&mutex_);
  status_.segment = state_->segment;
  newest_.reset();
}

void SessionWorker::MarkBroken(const absl::Status& why, ScanAck* ack) {
  is_broken_ = true;
  const uint64_t sequence = ack->sequence;
  *ack = ScanAck();
  ack->sequence = sequence;
  ack->outcome = ScanOutcome::kRejected;
  ack->reason = std::string(why.message());
  ack->tracking = Tracking::kLost;
  ++state_->counts.rejected;
  MutexLock lock(&mutex_);
  ++status_.rejected;
  status_.scans = state_->counts;
  status_.tracking = ack->tracking;
}

void SessionWorker::RestartSegment() {
  const uint32_t segment = state_->segment;
  const ScanCounts counts = state_->counts;
  const uint64_t first_lost = state_->unfinished.empty() ? 0 : state_->unfinished.front().sequence;
  MakeState(segment + 1, 0);
  state_->counts = counts;
  checkpoint_due_ = true;
  is_broken_ = false;
  {
    MutexLock lock(&mutex_);
    status_.segment = state_->segment;
    status_.lost_since_ns = 0;
    newest_.reset();
    std::erase_if(status_.unsaved[segment], [first_lost](const TrajectoryEntry& entry) {
      return first_lost > 0 && entry.sequence >= first_lost;
    });
  }
  Report(EventKind::kSegmentBegun,
         absl::StrCat(
             "goes on in segment ", state_->segment, " (",
             SegmentId(record_.id, state_->segment).value(), "), as the server failed at a scan",
             first_lost == 0
                 ? ""
                 : absl::StrCat("; what was not stored, from scan ", first_lost, " on, is lost")));
}

void SessionWorker::Report(EventKind kind, const std::string& what) const {
  if (!hooks_.tell) return;
  const ScanCounts& scans = state_->counts;
  Event event;
  event.kind = kind;
  event.robot = record_.robot;
  event.session = record_.id;
  event.text = absl::StrFormat(
      "session %s %s (scans so far: %d ok, %d degenerate, %d lost, %d "
      "rejected)",
      record_.id.value(), what, scans.ok, scans.degenerate, scans.lost, scans.rejected);
  hooks_.tell(std::move(event));
}

void SessionWorker::NoteTracking(bool is_lost, uint64_t sequence, int64_t stamp_ns) {
  const uint32_t lost_scans = state_->lost_scans;
  if (is_lost) {
    if (lost_scans == 0) state_->lost_since_ns = stamp_ns;
    if (++state_->lost_scans == kLostScans) {
      Report(EventKind::kRobotLost, absl::StrCat("is lost since scan ", sequence + 1 - kLostScans,
                                                 ", in segment ", state_->segment));
    }
    return;
  }
  state_->lost_since_ns = 0;
  state_->lost_scans = 0;
  if (lost_scans < kLostScans) return;
  Report(EventKind::kRobotFound,
         absl::StrCat("was found again with scan ", sequence, " after ", lost_scans,
                      " lost ones, in segment ", state_->segment));
}

// The odometry sees times that go forward; its results bear the robot's stamps.
absl::StatusOr<floam::OdometryResult> SessionWorker::TrackScan(const WaitingScan& waiting,
                                                               int64_t time_ns) {
  if (!waiting.refused.empty()) return absl::InvalidArgumentError(waiting.refused);
  const ScanUpload& upload = waiting.scan;
  absl::StatusOr<Scan> scan = DecodeScan(upload);
  if (!scan.ok()) return scan.status();
  scan->end_stamp_ns = time_ns;
  const StageTimer timer(options_.observer, Stage::kOdometry);
  absl::StatusOr<floam::OdometryResult> result = state_->odometry.Process(*scan);
  if (result.ok()) result->stamp_ns = upload.end_stamp_ns;
  return result;
}

absl::StatusOr<Scan> SessionWorker::DecodeScan(const ScanUpload& upload) {
  const StageTimer timer(options_.observer, Stage::kDecode);
  absl::StatusOr<Scan> scan =
      state_->decoder.Decode(upload.payload, upload.sequence, upload.end_stamp_ns);
  if (scan.ok()) ThinScan(kMaxTrackedPoints, &*scan);
  return scan;
}

void SessionWorker::RejectScan(const ScanUpload& scan, const absl::Status& why, ScanAck* ack) {
  ack->outcome = ScanOutcome::kRejected;
  ack->reason = std::string(why.message());
  ack->tracking = Tracking::kLost;
  ++state_->counts.rejected;
  if (++state_->blind_scans == kBlindScans) FinishSubmap(state_->builder->Finish());
  bool has_begun = state_->segment > 1;
  {
    MutexLock lock(&mutex_);
    has_begun = has_begun || newest_.has_value();
  }
  if (has_begun) NoteTracking(true, scan.sequence, scan.end_stamp_ns);
  MutexLock lock(&mutex_);
  ++status_.rejected;
  status_.scans = state_->counts;
  status_.lost_since_ns = state_->lost_since_ns;
  if (has_begun) {
    status_.tracking = ack->tracking;
  } else {
    status_.input = absl::StrCat("no scan could be used so far: ", ack->reason);
  }
}

void SessionWorker::TakeResult(const floam::OdometryResult& result, ScanAck* ack) {
  state_->blind_scans = 0;
  const bool lost = result.status == floam::TrackingStatus::kLost;
  if (lost) FinishSubmap(state_->builder->Finish());
  const TrajectoryEntry entry{result.sequence, result.stamp_ns, result.T_odom_sensor,
                              state_->builder->CurrentIndex()};
  if (!lost) state_->unfinished.push_back(entry);
  FinishSubmap(state_->builder->Add(result));
  ScanCounts& scans = state_->counts;
  ++(lost                                                  ? scans.lost
     : result.status == floam::TrackingStatus::kDegenerate ? scans.degenerate
                                                           : scans.ok);
  NoteTracking(lost, result.sequence, result.stamp_ns);

  ack->tracking = TrackingOf(result.status);
  ack->T_odom_sensor = result.T_odom_sensor;
  ack->covariance = result.covariance;
  ack->unobserved_translations = result.degeneracy.translations;
  ack->unobserved_rotations = result.degeneracy.rotations;
  ack->timing = {result.timing.features_ms, result.timing.matching_ms, result.timing.map_ms,
                 result.timing.total_ms};

  MutexLock lock(&mutex_);
  ++status_.processed;
  odometry_ms_sum_ += result.timing.total_ms;
  status_.odometry_ms_mean = odometry_ms_sum_ / static_cast<double>(status_.processed);
  status_.tracking = ack->tracking;
  status_.scans = scans;
  status_.lost_since_ns = state_->lost_since_ns;
  status_.input = InputText(state_->decoder.fields(), result);
  if (!status_.resumed.empty()) absl::StrAppend(&status_.input, "; ", status_.resumed);
  if (lost) return;
  FollowPose(entry, state_->segment);
  status_.unsaved[state_->segment].push_back(entry);
}

}  // namespace isthmus::ingest
