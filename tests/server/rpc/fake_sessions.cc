#include "tests/server/rpc/fake_sessions.h"

#include <absl/strings/str_cat.h>

#include <algorithm>
#include <utility>

namespace isthmus::rpc {

absl::StatusOr<FakeSessions::Session*> FakeSessions::Find(const SessionId& session) const {
  const auto found = sessions_.find(session);
  if (found == sessions_.end()) {
    return absl::NotFoundError(absl::StrCat("no session \"", session.value(), "\""));
  }
  return &found->second;
}

absl::StatusOr<SessionStatus> FakeSessions::Create(const SessionRequest& request, const Actor& by) {
  actors.push_back(by);
  MutexLock lock(&mutex_);
  if (request.robot.empty()) return absl::InvalidArgumentError("the robot has no name");
  SessionStatus status;
  status.record.id = SessionId(absl::StrCat(request.robot.value(), "-", sessions_.size() + 1));
  status.record.robot = request.robot;
  status.record.sensor = request.sensor;
  status.record.odometry = request.odometry;
  status.record.T_base_sensor = request.T_base_sensor;
  status.record.created_ns = 1000;
  status.segments = 3;
  status.scans = {21, 22, 23, 24};
  status.lost_since_ns = 25;
  sessions_[status.record.id].status = status;
  return status;
}

absl::StatusOr<SessionStatus> FakeSessions::Get(const SessionId& session) const {
  MutexLock lock(&mutex_);
  const auto found = Find(session);
  if (!found.ok()) return found.status();
  return (*found)->status;
}

std::vector<SessionStatus> FakeSessions::List() const {
  MutexLock lock(&mutex_);
  std::vector<SessionStatus> list;
  for (const auto& [id, session] : sessions_) list.push_back(session.status);
  return list;
}

absl::StatusOr<SessionStatus> FakeSessions::Finish(const SessionId& session, const Actor& by) {
  actors.push_back(by);
  MutexLock lock(&mutex_);
  const auto found = Find(session);
  if (!found.ok()) return found.status();
  (*found)->status.record.state = SessionState::kFinished;
  (*found)->status.record.finished_ns = 2000;
  return (*found)->status;
}

absl::Status FakeSessions::Delete(const SessionId& session, const Actor& by) {
  actors.push_back(by);
  MutexLock lock(&mutex_);
  const auto found = Find(session);
  if (!found.ok()) return found.status();
  sessions_.erase(session);
  std::erase_if(queue_, [&](const Queued& queued) { return queued.session == session; });
  changed_.SignalAll();
  return absl::OkStatus();
}

absl::Status FakeSessions::SetAckSink(const SessionId& session, AckSink sink) {
  MutexLock lock(&mutex_);
  const auto found = Find(session);
  if (!found.ok()) return found.status();
  if (sink && (*found)->status.record.state == SessionState::kFinished) {
    return absl::FailedPreconditionError("the session is finished");
  }
  (*found)->sink = std::move(sink);
  return absl::OkStatus();
}

absl::StatusOr<bool> FakeSessions::OfferScan(const SessionId& session, ScanUpload* scan) {
  MutexLock lock(&mutex_);
  if (capacity_ > 0 && queue_.size() >= capacity_) return false;
  const auto found = Find(session);
  if (!found.ok()) return found.status();
  if (scan->sequence > (*found)->last_submitted + 1) {
    return absl::OutOfRangeError(absl::StrCat(
        "scan ", scan->sequence, " leaves a gap: ", (*found)->last_submitted + 1, " is expected"));
  }
  (*found)->last_submitted = std::max((*found)->last_submitted, scan->sequence);
  ++submitted_;
  if (capacity_ > 0) {
    queue_.push_back({session, std::move(*scan)});
    changed_.SignalAll();
    return true;
  }
  const ScanAck ack = Handle(**found, *scan);
  if ((*found)->sink) (*found)->sink(ack);
  return true;
}

ScanAck FakeSessions::Handle(Session& session, const ScanUpload& scan) {
  ScanAck ack;
  ack.sequence = scan.sequence;
  ack.durable_sequence = session.status.durable_sequence;
  if (scan.sequence <= session.status.last_sequence) {
    ack.outcome = ScanOutcome::kDuplicate;
    return ack;
  }
  session.status.last_sequence = scan.sequence;
  if (scan.payload.data.empty()) {
    ack.outcome = ScanOutcome::kRejected;
    ack.reason = "the scan is empty";
    return ack;
  }
  ack.tracking = Tracking::kOk;
  ack.T_odom_sensor = Pose(Eigen::Vector3d(static_cast<double>(scan.sequence), 0, 0));
  ack.timing.total_ms = 3.5;
  ack.segment = 2;
  ack.segment_session = SegmentId(session.status.record.id, 2);
  ack.lost_since_ns = 7;
  ack.scans = {11, 12, 13, 14};
  // Every entry differs, so that none can take another's place on the way.
  Matrix6d covariance;
  for (int i = 0; i < 6; ++i) {
    for (int k = 0; k < 6; ++k) covariance(i, k) = 10 * std::min(i, k) + std::max(i, k);
  }
  ack.covariance = covariance;
  ack.unobserved_translations = {{1, 0, 0}, {0, 0.6, 0.8}};
  ack.unobserved_rotations = {{0, 0, 1}};
  return ack;
}

absl::StatusOr<SubmapInfo> FakeSessions::AddSubmap(Submap submap) {
  MutexLock lock(&mutex_);
  submaps_.push_back(std::move(submap));
  return Summarize(submaps_.back());
}

void FakeSessions::Hold(size_t capacity) {
  MutexLock lock(&mutex_);
  capacity_ = capacity;
}

void FakeSessions::Release() {
  MutexLock lock(&mutex_);
  capacity_ = 0;
  for (const Queued& queued : queue_) {
    Session& session = sessions_.at(queued.session);
    const ScanAck ack = Handle(session, queued.scan);
    if (session.sink) session.sink(ack);
  }
  queue_.clear();
  changed_.SignalAll();
}

size_t FakeSessions::Waiting() {
  MutexLock lock(&mutex_);
  return queue_.size();
}

void FakeSessions::WaitForQueued(size_t scans) {
  MutexLock lock(&mutex_);
  while (queue_.size() < scans) changed_.Wait(&mutex_);
}

void FakeSessions::MakeDurable(const SessionId& session, uint64_t sequence) {
  MutexLock lock(&mutex_);
  Session& found = sessions_.at(session);
  found.status.durable_sequence = sequence;
  ScanAck ack;
  ack.durable_sequence = sequence;
  if (found.sink) found.sink(ack);
}

std::vector<Submap> FakeSessions::submaps() {
  MutexLock lock(&mutex_);
  return submaps_;
}

size_t FakeSessions::submitted() {
  MutexLock lock(&mutex_);
  return submitted_;
}

}  // namespace isthmus::rpc
