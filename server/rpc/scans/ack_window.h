// The bounded hand-over of acknowledgements from the pipeline's thread to the stream that writes
// them to the robot.
//
// The pipeline must never wait for a slow reader, and no acknowledgement of a scan may be dropped.
// So the bound is held at the other end: no further scan is read from the robot while `limit` of
// its scans, or scans of so many bytes, have no acknowledgement written yet.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "core/concurrency/mutex.h"
#include "core/scan_upload.h"
#include "server/rpc/streams/byte_budget.h"

namespace isthmus::rpc {

// Thread safe, never waits; meant for one stream and the pipeline.
class AckWindow {
 public:
  struct Limits {
    size_t scans = 64;
    size_t bytes = SIZE_MAX;  // One scan may always be under way, whatever its size.
  };
  // `on_change` is called when there is something new for the stream, from whatever thread; it must
  // not wait, nor call back. It may be null.
  AckWindow(const Limits& limits, std::function<void()> on_change)
      : limits_(limits), on_change_(std::move(on_change)) {}

  // Stream: whether one more scan may be read. False once closed.
  bool HasRoom() const;
  // Stream: a scan is about to be submitted. `reason` replaces the pipeline's if it is rejected.
  // `share`, which may be null, is held until the scan is acknowledged.
  void Expect(uint64_t sequence, std::string reason = {},
              std::unique_ptr<ByteBudget::Share> share = nullptr);
  // Stream: the pipeline did not take the scan; there will be no ack of it. What Expect was given.
  std::pair<std::string, std::unique_ptr<ByteBudget::Share>> Withdraw(uint64_t sequence);
  // Stream: no more scans come.
  void EndScans();

  // Pipeline: an ack of a scan that this stream did not send (an earlier stream of the session did)
  // only moves durable_sequence.
  void Add(ScanAck ack);

  // Stream: the next ack to write, if there is one.
  std::optional<ScanAck> Next();
  // No more scans come, and every ack was taken by Next().
  bool drained() const;

  // From anywhere: the link is gone. Acks are let go.
  void Close();
  bool closed() const;

 private:
  struct Expected {
    uint64_t sequence;
    std::string reason;
    std::unique_ptr<ByteBudget::Share> share;
  };

  void AddDurable(uint64_t durable_sequence) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  // Returns what the scan held.
  std::unique_ptr<ByteBudget::Share> TakeAck(ScanAck ack) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void Changed() const;

  const Limits limits_;
  const std::function<void()> on_change_;
  mutable Mutex mutex_;
  std::deque<Expected> expected_ ABSL_GUARDED_BY(mutex_);
  size_t bytes_ ABSL_GUARDED_BY(mutex_) = 0;  // Bytes of the scans in expected_.
  std::deque<ScanAck> acks_ ABSL_GUARDED_BY(mutex_);
  size_t unwritten_ ABSL_GUARDED_BY(mutex_) = 0;  // Acks of scans in acks_.
  bool ended_ ABSL_GUARDED_BY(mutex_) = false;
  bool closed_ ABSL_GUARDED_BY(mutex_) = false;
};

}  // namespace isthmus::rpc
