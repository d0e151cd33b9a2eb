#include "lab/loadgen/load_robot.h"

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <random>
#include <thread>
#include <utility>

#include "core/stopwatch.h"
#include "lab/loadgen/limits.h"

namespace isthmus::loadgen {
namespace {

constexpr int64_t kPeriodNs = 100'000'000;  // Format.

double RobotNowS() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

void SleepUntil(double s) {
  std::this_thread::sleep_for(std::chrono::duration<double>(std::max(0.0, s - RobotNowS())));
}

}  // namespace

LoadRobot::LoadRobot(RobotPlan plan) : plan_(std::move(plan)) { result_.name = plan_.name; }

void LoadRobot::Run() {
  std::unique_ptr<Relay> relay;
  client::ClientOptions options;
  options.address = plan_.server;
  options.backoff.max_attempts = kAttempts;
  absl::Status status;
  if (!plan_.link.is_perfect()) {
    auto opened = Relay::Open(plan_.server, plan_.link, plan_.seed);
    status = opened.status();
    if (opened.ok()) {
      relay = *std::move(opened);
      options.address = relay->address();
    }
  }
  if (status.ok()) {
    SleepUntil(RobotNowS() + plan_.start_s);
    auto client = client::Client::Connect(options);
    status = client.ok() ? Drive(**client) : client.status();
  }
  MutexLock lock(&mutex_);
  result_.status = std::move(status);
}

absl::Status LoadRobot::Drive(client::Client& client) {
  SessionRequest request;
  request.robot = RobotId(plan_.name);
  request.sensor = plan_.drive->sensor;
  request.when_behind = plan_.when_behind;
  const auto session = client.CreateSession(request);
  if (!session.ok()) return session.status();
  client::ScanStreamOptions options;
  options.on_ack = [this](const ScanAck& ack) { Note(ack); };
  const auto stream = client.OpenScanStream(session->record.id, options);
  if (!stream.ok()) return stream.status();
  absl::Status status = Send(**stream);
  const Stopwatch finishing;
  if (status.ok() && !plan_.is_beside) status = (*stream)->FinishSession().status();
  const client::ScanStreamStats stats = (*stream)->stats();
  MutexLock lock(&mutex_);
  result_.finish_s = finishing.Ms() / 1e3;
  result_.reconnects = stats.reconnects;
  result_.cloud_bytes = stats.sent_bytes;
  return status;
}

absl::Status LoadRobot::Send(client::ScanStream& stream) {
  std::mt19937_64 random(plan_.seed);
  std::uniform_real_distribution<double> jitter_s(0, plan_.jitter_s);
  const std::vector<Drive::OneScan>& scans = plan_.drive->scans;
  const size_t left = scans.size() - std::min(scans.size(), plan_.first_scan);
  const size_t count = plan_.is_beside ? SIZE_MAX : std::min(plan_.scans, left);
  const double start_s = RobotNowS(), rate_hz = plan_.rate_hz;
  for (size_t i = 0; i < count && !stopped_; ++i) {
    double due_s = RobotNowS();
    if (rate_hz > 0) {
      due_s = start_s + static_cast<double>(i) / rate_hz + jitter_s(random);
      SleepUntil(due_s);
    }
    {
      MutexLock lock(&mutex_);
      due_s_.push_back(due_s);
      ++result_.pushed;
      if (rate_hz > 0 && RobotNowS() > due_s + 1 / rate_hz) ++result_.late;
    }
    const Drive::OneScan& scan = scans[(plan_.first_scan + i) % scans.size()];
    // Each time round it is later.
    const int64_t length_ns = scans.back().end_stamp_ns - scans.front().end_stamp_ns + kPeriodNs;
    const auto turn = static_cast<int64_t>((plan_.first_scan + i) / scans.size());
    absl::Status status = stream.Push(scan.end_stamp_ns + turn * length_ns, scan.payload);
    if (!status.ok()) return status;
  }
  return absl::OkStatus();
}

void LoadRobot::Note(const ScanAck& ack) {
  const double now_s = RobotNowS();
  MutexLock lock(&mutex_);
  if (ack.sequence == 0 || ack.sequence > due_s_.size()) return;
  result_.ack_ms.push_back(1e3 * (now_s - due_s_[ack.sequence - 1]));
  result_.most_undurable =
      std::max(result_.most_undurable, ack.sequence - std::min(ack.sequence, ack.durable_sequence));
  switch (ack.outcome) {
    case ScanOutcome::kProcessed:
      ++result_.processed;
      result_.odometry_ms.push_back(ack.timing.total_ms);
      if (ack.tracking == Tracking::kLost) ++result_.lost;
      break;
    case ScanOutcome::kDuplicate:
      ++result_.duplicates;
      break;
    case ScanOutcome::kSkipped:
      ++result_.skipped;
      break;
    case ScanOutcome::kRejected:
      if (result_.rejected++ == 0) result_.first_rejection = ack.reason;
      break;
  }
}

uint64_t LoadRobot::acknowledged() const {
  MutexLock lock(&mutex_);
  return result_.ack_ms.size();
}

RobotResult LoadRobot::Result() {
  MutexLock lock(&mutex_);
  result_.unanswered = result_.pushed - std::min(result_.pushed, result_.ack_ms.size());
  return result_;
}

}  // namespace isthmus::loadgen
