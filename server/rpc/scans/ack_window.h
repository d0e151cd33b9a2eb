// The bounded hand-over of acknowledgements from the pipeline's thread to the one that writes them
// to the robot.
//
// The pipeline must never wait for a slow reader, and no acknowledgement of a scan may be dropped.
// So the bound is held at the other end: no further scan is read from the robot while `limit` of
// its scans have no acknowledgement written yet.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <string>

#include "core/concurrency/mutex.h"
#include "core/scan_upload.h"

namespace isthmus::rpc {

// Thread safe; meant for one reader of scans, one writer of acks, and the pipeline.
class AckWindow {
 public:
  explicit AckWindow(size_t limit) : limit_(limit) {}

  // Reader: waits until one more scan may be read. False once stopped or closed.
  bool WaitForRoom();
  // Reader: a scan is about to be submitted. `reason` replaces the pipeline's if it is rejected.
  void Expect(uint64_t sequence, std::string reason = {});
  // Reader: the pipeline did not take the scan; there will be no ack of it.
  void Withdraw(uint64_t sequence);
  // Reader: no more scans come. Next() ends after the acks still expected.
  void EndScans();
  bool scans_ended() const;

  // Pipeline: never waits. An ack of a scan that this stream did not send (an earlier stream of the
  // session did) only moves durable_sequence.
  void Add(ScanAck ack);

  // Writer: waits for the next ack. Empty once closed, or once all are out and no more scans come.
  std::optional<ScanAck> Next();

  // From anywhere: no more scans are read, those expected are still acknowledged.
  void Stop();
  // From anywhere: the link is gone. Nobody waits any more, acks are let go.
  void Close();

 private:
  struct Expected {
    uint64_t sequence;
    std::string reason;
  };

  void AddDurable(uint64_t durable_sequence) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  const size_t limit_;
  mutable Mutex mutex_;
  CondVar changed_;
  std::deque<Expected> expected_ ABSL_GUARDED_BY(mutex_);
  std::deque<ScanAck> acks_ ABSL_GUARDED_BY(mutex_);
  size_t unwritten_ ABSL_GUARDED_BY(mutex_) = 0;  // Of scans, in acks_.
  bool stopped_ ABSL_GUARDED_BY(mutex_) = false;
  bool ended_ ABSL_GUARDED_BY(mutex_) = false;
  bool closed_ ABSL_GUARDED_BY(mutex_) = false;
};

}  // namespace isthmus::rpc
