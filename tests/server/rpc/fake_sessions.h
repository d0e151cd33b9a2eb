// Sessions in memory, whose scans are acknowledged at once or when the test says so.
#pragma once

#include <deque>
#include <map>
#include <vector>

#include "core/concurrency/mutex.h"
#include "core/map/anchor.h"
#include "core/records/map_info.h"
#include "server/sessions.h"

namespace isthmus::rpc {

// The records that the parts of a fake pipeline share.
class FakeRecords {
 public:
  MapInfo info;               // Set before use. `info.revision` is the lists' revision, too.
  std::vector<Actor> actors;  // One per change, in order.
  std::vector<Anchor> anchors;

 protected:
  struct Session {
    SessionStatus status;
    AckSink sink;
    uint64_t last_submitted = 0;
  };

  mutable Mutex mutex_;
  mutable std::map<SessionId, Session> sessions_ ABSL_GUARDED_BY(mutex_);
  std::vector<Submap> submaps_ ABSL_GUARDED_BY(mutex_);
};

class FakeSessions : public server::Sessions, public virtual FakeRecords {
 public:
  absl::StatusOr<SessionStatus> Create(const SessionRequest& request, const Actor& by) override;
  absl::StatusOr<SessionStatus> Get(const SessionId& session) const override;
  std::vector<SessionStatus> List() const override;
  absl::StatusOr<SessionStatus> Finish(const SessionId& session, const Actor& by) override;
  absl::Status Delete(const SessionId& session, const Actor& by) override;
  absl::Status SetAckSink(const SessionId& session, AckSink sink) override;
  absl::Status SubmitScan(const SessionId& session, ScanUpload scan) override {
    return OfferScan(session, &scan).status();
  }
  absl::StatusOr<bool> OfferScan(const SessionId& session, ScanUpload* scan) override;
  absl::StatusOr<SubmapInfo> AddSubmap(Submap submap) override;

  // While held, scans wait in a queue of `capacity`; no more is taken when it is full.
  void Hold(size_t capacity);
  // Acknowledges what waits, and scans to come at once.
  void Release();
  size_t Waiting();
  // Waits until so many scans are in the queue.
  void WaitForQueued(size_t scans);
  // Sends an ack that only moves durable_sequence.
  void MakeDurable(const SessionId& session, uint64_t sequence);
  std::vector<Submap> submaps();
  // Scans taken, duplicates included.
  size_t submitted();

 private:
  struct Queued {
    SessionId session;
    ScanUpload scan;
  };

  absl::StatusOr<Session*> Find(const SessionId& session) const
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  ScanAck Handle(Session& session, const ScanUpload& scan) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  CondVar changed_;
  std::deque<Queued> queue_ ABSL_GUARDED_BY(mutex_);
  size_t submitted_ ABSL_GUARDED_BY(mutex_) = 0;
  size_t capacity_ ABSL_GUARDED_BY(mutex_) = 0;  // 0: not held.
};

}  // namespace isthmus::rpc
