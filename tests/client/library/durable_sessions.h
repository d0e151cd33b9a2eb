// A server's record of its sessions: scans that took effect, the durable ones, and those left after
// a crash. It forgets and loses answers when told to. DurableServer or DurableLink is the way to
// it.
#pragma once

#include <absl/status/status.h>

#include <atomic>
#include <map>
#include <string>
#include <vector>

#include "core/concurrency/mutex.h"
#include "isthmus/v1/session_service.pb.h"

namespace isthmus::client {

struct FakeSession {
  v1::CreateSessionRequest request;
  std::vector<v1::ScanMessage> scans;  // Scans that took effect; the k-th has sequence k + 1.
  uint64_t durable = 0;
  bool finished = false;
  int64_t created_ns = 1;
};

// Thread safe.
class DurableSessions {
 public:
  std::atomic<uint64_t> durable_every{1};  // Scans; the last multiple of it is durable.
  std::atomic<int> lost_creations{0};      // So many sessions are opened without an answer.
  std::atomic<int> crashes_at_finish{0};   // So many calls of FinishSession meet a crash.
  std::atomic<int> break_every{0};         // A stream ends after so many scans; 0: never.
  std::atomic<absl::StatusCode> break_code{absl::StatusCode::kUnavailable};  // Its end.
  std::atomic<uint32_t> quantized_version{0};  // The version that it says it reads.
  std::atomic<int> mute_streams{0};            // So many streams take nothing and say nothing.
  std::atomic<int> creations{0}, streams{0}, muted{0}, got_bytes{0}, got_scans{0};

  std::map<std::string, FakeSession> sessions() {
    MutexLock lock(&mutex_);
    return sessions_;
  }
  template <typename Change>
  void Edit(const Change& change) {
    MutexLock lock(&mutex_);
    change(sessions_);
    changed_.SignalAll();
  }
  template <typename Condition>
  void WaitFor(const Condition& condition) {
    MutexLock lock(&mutex_);
    while (!condition(sessions_)) changed_.Wait(&mutex_);
  }
  void WaitForScans(const std::string& id, size_t count) {
    WaitFor([&](auto& sessions) {
      return sessions.count(id) != 0 && sessions[id].scans.size() >= count;
    });
  }

 protected:
  absl::Status Broken() const { return {break_code, "broken on purpose"}; }

  // Forgets all that was not durable.
  void Forget() {
    MutexLock lock(&mutex_);
    for (auto& [id, session] : sessions_) session.scans.resize(session.durable);
  }

  absl::Status Create(const v1::CreateSessionRequest& request, v1::Session* session) {
    MutexLock lock(&mutex_);
    ++creations;
    for (auto& [id, known] : sessions_) {
      if (known.request.request_id() == request.request_id()) return Tell(id, session);
    }
    const std::string id = request.robot() + "-" + std::to_string(sessions_.size() + 1);
    sessions_[id].request = request;
    changed_.SignalAll();
    if (lost_creations > 0 && lost_creations-- > 0) {
      return absl::UnavailableError("the answer was lost");
    }
    return Tell(id, session);
  }

  absl::Status Get(const v1::GetSessionRequest& request, v1::Session* session) {
    MutexLock lock(&mutex_);
    return Tell(request.session(), session);
  }

  absl::Status Finish(const v1::FinishSessionRequest& request, v1::Session* session) {
    MutexLock lock(&mutex_);
    FakeSession& known = sessions_[request.session()];
    if (crashes_at_finish > 0 && crashes_at_finish-- > 0) known.scans.resize(known.durable);
    if (known.scans.size() < request.last_sequence()) {
      return absl::AbortedError("not all of that has taken effect");
    }
    known.durable = known.scans.size();
    known.finished = true;
    changed_.SignalAll();
    return Tell(request.session(), session);
  }

  // A stream begins; true if it is to be mute.
  bool BeginStream() {
    MutexLock lock(&mutex_);
    ++streams;
    changed_.SignalAll();
    return mute_streams > 0 && mute_streams-- > 0;
  }

  absl::Status Take(const std::string& id, const v1::ScanMessage& scan,
                    v1::StreamScansResponse& ack) {
    MutexLock lock(&mutex_);
    const auto found = sessions_.find(id);
    if (found == sessions_.end()) return absl::NotFoundError("no such session");
    FakeSession& session = found->second;
    if (session.finished) return absl::FailedPreconditionError("it is finished");
    const uint64_t last = session.scans.size();
    if (scan.sequence() > last + 1) return absl::OutOfRangeError("a scan was left out");
    ++got_scans;
    got_bytes += static_cast<int>(scan.cloud().data().size());
    ack.set_outcome(scan.sequence() <= last       ? v1::StreamScansResponse::DUPLICATE
                    : scan.cloud().data().empty() ? v1::StreamScansResponse::REJECTED
                                                  : v1::StreamScansResponse::PROCESSED);
    if (scan.sequence() == last + 1) session.scans.push_back(scan);
    session.durable = session.scans.size() / durable_every * durable_every;
    ack.set_sequence(scan.sequence());
    ack.set_durable_sequence(session.durable);
    changed_.SignalAll();
    return absl::OkStatus();
  }

  void Mute() {
    MutexLock lock(&mutex_);
    ++muted;
    changed_.SignalAll();
  }

 private:
  absl::Status Tell(const std::string& id, v1::Session* session)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    const auto found = sessions_.find(id);
    if (found == sessions_.end()) return absl::NotFoundError("no such session");
    session->set_id(id);
    session->set_quantized_version(quantized_version);
    session->set_robot(found->second.request.robot());
    session->set_created_ns(found->second.created_ns);
    session->set_last_sequence(found->second.scans.size());
    session->set_durable_sequence(found->second.durable);
    session->set_state(found->second.finished ? v1::Session::FINISHED : v1::Session::ACTIVE);
    return absl::OkStatus();
  }

  Mutex mutex_;
  CondVar changed_;
  std::map<std::string, FakeSession> sessions_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace isthmus::client
