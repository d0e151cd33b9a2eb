#include "client/console/push_keyframes.h"

#include <cstdio>
#include <deque>
#include <memory>
#include <optional>
#include <thread>
#include <utility>

#include "client/console/pacer.h"
#include "client/console/say.h"
#include "client/console/submap_sender.h"
#include "client/follower/follower.h"
#include "core/concurrency/mutex.h"

namespace isthmus::cli {
namespace {

using follower::FollowedSubmap;
using follower::Follower;

// Bytes of submaps that wait to be sent: about an hour's of a VLP-16.
constexpr size_t kMaxWaitingBytes = size_t{256} << 20;

// Sends submaps from a thread of its own, so that a slow link does not hold up the odometry.
class SendQueue {
 public:
  SendQueue(client::Client& client, SubmapTarget target, bool finish)
      : target_(std::move(target)), finish_(finish), client_(client), thread_([this] { Run(); }) {}
  ~SendQueue() { (void)End(false); }

  // Waits for room. The first error of sending.
  absl::Status Add(std::vector<FollowedSubmap> submaps) {
    MutexLock lock(&mutex_);
    for (FollowedSubmap& submap : submaps) {
      while (bytes_ >= kMaxWaitingBytes && status_.ok()) changed_.Wait(&mutex_);
      bytes_ += submap.upload.cloud.data.size();
      waiting_.push_back(std::move(submap));
      changed_.SignalAll();
    }
    return status_;
  }

  // Returns when all is sent; finishes the newest session if `finish`.
  absl::Status End(bool finish) {
    {
      MutexLock lock(&mutex_);
      has_ended_ = true;
      finish_ = finish_ && finish;
      changed_.SignalAll();
    }
    if (thread_.joinable()) thread_.join();
    MutexLock lock(&mutex_);
    return status_;
  }

  // Once ended.
  void Fill(KeyframeSummary& summary) const {
    summary.scans.sent_bytes = sent_bytes_;
    if (!sender_) return;
    summary.session = sender_->session();
    summary.was_finished = sender_->was_finished();
    summary.scans.sent_bytes += sender_->sent_bytes();
  }

 private:
  std::optional<FollowedSubmap> Next() {
    MutexLock lock(&mutex_);
    while (!has_ended_ && waiting_.empty()) changed_.Wait(&mutex_);
    if (waiting_.empty()) return std::nullopt;
    FollowedSubmap next = std::move(waiting_.front());
    waiting_.pop_front();
    return next;
  }

  void Run() {
    while (std::optional<FollowedSubmap> next = Next()) {
      const size_t bytes = next->upload.cloud.data.size();
      const absl::Status status = Send(*std::move(next));
      MutexLock lock(&mutex_);
      bytes_ -= bytes;
      changed_.SignalAll();
      if (status.ok()) continue;
      status_ = status;
      return;
    }
    if (!sender_ || !WantsFinish()) return;
    const absl::Status status = sender_->Finish();
    MutexLock lock(&mutex_);
    status_ = status;
  }

  absl::Status Send(FollowedSubmap next) {
    if (!sender_ || next.segment != segment_) {
      if (sender_) {
        sent_bytes_ += sender_->sent_bytes();
        if (absl::Status status = sender_->Finish(); !status.ok()) return status;
      }
      sender_.emplace(client_, target_);
      segment_ = next.segment;
    }
    for (bool is_told = false;;) {
      const absl::Status status = sender_->Send(next.upload);
      // As long as the robot drives, it may come into reach again.
      if (!absl::IsUnavailable(status) || IsLast()) return status;
      if (!is_told) {
        Warn("isthmus: %s: %s; its submaps wait\n", target_.request.robot.value(),
             std::string(status.message()));
      }
      is_told = true;
    }
  }

  bool IsLast() const {
    MutexLock lock(&mutex_);
    return has_ended_;
  }
  bool WantsFinish() const {
    MutexLock lock(&mutex_);
    return finish_;
  }

  const SubmapTarget target_;
  mutable Mutex mutex_;
  CondVar changed_;
  std::deque<FollowedSubmap> waiting_ ABSL_GUARDED_BY(mutex_);
  size_t bytes_ ABSL_GUARDED_BY(mutex_) = 0;  // The submap being sent included.
  bool has_ended_ ABSL_GUARDED_BY(mutex_) = false;
  bool finish_ ABSL_GUARDED_BY(mutex_);
  absl::Status status_ ABSL_GUARDED_BY(mutex_);
  // The thread's fields, until it has ended.
  client::Client& client_;
  std::optional<SubmapSender> sender_;
  uint32_t segment_ = 0;
  uint64_t sent_bytes_ = 0;  // Bytes of earlier segments.
  std::thread thread_;       // Last: it uses the others.
};

// The odometry is ours, so the session is opened without one.
SubmapTarget TargetOf(SessionRequest request) {
  request.odometry.reset();
  return {std::move(request), {}};
}

}  // namespace

absl::StatusOr<KeyframeSummary> PushKeyframes(client::Client& client, RobotScans& robot,
                                              const PushOptions& options,
                                              const PushControl& control,
                                              const KeyframeHooks& hooks) {
  const SessionRequest request = RequestOf(robot, options);
  const auto follower = Follower::Create(
      {request.sensor, request.T_base_sensor, request.odometry, options.resolution_m});
  if (!follower.ok()) return follower.status();
  KeyframeSummary summary;
  SendQueue queue(client, TargetOf(request), options.finish);
  Pacer pacer(options.pace_hz);
  while (!control.stopped()) {
    const auto scan = robot.reader->Next();
    if (!scan.ok()) {
      hooks.left_out("", scan.status());
      continue;
    }
    if (!scan->has_value()) break;
    pacer.Wait();
    auto followed =
        (*follower)->Take((*scan)->payload, ++summary.scans.pushed, (*scan)->end_stamp_ns);
    if (!followed.ok()) return followed.status();
    if (auto status = queue.Add(std::move(followed->submaps)); !status.ok()) return status;
    const bool rejected = followed->ack.outcome == ScanOutcome::kRejected;
    ++(rejected ? summary.scans.rejected : summary.scans.processed);
    hooks.on_ack(followed->ack);
  }
  const bool is_whole = !control.stopped() || options.is_live;
  if (is_whole) {
    auto last = (*follower)->Finish();
    if (!last.ok()) return last.status();
    if (auto status = queue.Add(*std::move(last)); !status.ok()) return status;
  }
  if (auto status = queue.End(is_whole); !status.ok()) return status;
  queue.Fill(summary);
  if (summary.was_finished) {
    Warn("isthmus: nothing left to push: session %s has everything and is finished\n",
         summary.session.value());
  }
  if (is_whole) summary.durable_sequence = summary.scans.pushed;
  summary.counts = (*follower)->counts();
  summary.segments = (*follower)->segment();
  return summary;
}

}  // namespace isthmus::cli
