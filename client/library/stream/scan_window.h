// The window of scans that a robot has to keep, and to send again after a lost link.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <utility>

namespace isthmus::client {

// Scans that were handed to the stream and may still be needed, by ascending sequence without
// gaps. A scan is kept until it is durable at the server: one that was acknowledged but not yet
// durable is lost if the server dies. Of those, the oldest are given up first when the spool
// exceeds its limit; scans without acknowledgement are never given up. Not thread safe.
//
// T is what is sent; the window only counts its bytes. A scan has its number from when it is sent.
template <typename T>
class ScanWindow {
 public:
  // At most `window` scans without acknowledgement, and `spool_bytes` of acknowledged ones.
  ScanWindow(uint64_t first_sequence, size_t window, size_t spool_bytes)
      : window_(window),
        spool_bytes_(spool_bytes),
        next_(first_sequence),
        to_send_(first_sequence),
        acked_(first_sequence - 1),
        at_server_(first_sequence - 1) {}

  bool full() const { return next_ - 1 - acked_ >= window_; }
  bool all_acked() const { return acked_ + 1 == next_; }
  // The server has all of them, and has not lost any of them since it acknowledged it.
  bool settled() const { return all_acked() && at_server_ >= acked_; }
  uint64_t acked_sequence() const { return acked_; }
  uint64_t at_server() const { return at_server_; }
  // The highest that was ever sent; nothing before the first.
  std::optional<uint64_t> sent() const { return sent_; }

  // Must not be full.
  void Add(std::shared_ptr<T> scan, size_t bytes) {
    entries_.push_back({std::move(scan), bytes});
    ++next_;
  }

  struct Unsent {
    std::shared_ptr<T> scan;  // Null when all were sent.
    uint64_t sequence = 0;
  };
  // The next scan to put on the wire.
  Unsent TakeUnsent() {
    if (to_send_ >= next_) return {};
    sent_ = std::max(sent_.value_or(0), to_send_);
    const uint64_t sequence = to_send_++;
    return {entries_[sequence - first()].scan, sequence};
  }

  // Acknowledgement of a scan; of one that was never sent it counts for nothing. False when it had
  // been acknowledged before (and was sent again only because it was not durable), or was never
  // sent: not to be reported to the robot.
  bool Ack(uint64_t sequence) {
    if (sequence > sent_.value_or(0)) return false;
    at_server_ = std::max(at_server_, sequence);
    if (sequence != acked_ + 1 || sequence >= to_send_) return false;
    acked_ = sequence;
    acked_bytes_ += entries_[sequence - first()].bytes;
    while (acked_bytes_ > spool_bytes_) PopFront();
    return true;
  }

  // Everything up to `sequence` survives a crash of the server. What was not acknowledged stays.
  void Durable(uint64_t sequence) {
    while (first() <= sequence && first() <= acked_) PopFront();
  }

  // Nothing was sent so far, and the server has scans up to `last_sequence` already.
  void Renumber(uint64_t last_sequence) {
    next_ = last_sequence + 1 + entries_.size();
    to_send_ = last_sequence + 1;
    acked_ = at_server_ = last_sequence;
  }

  // A new link to a server that has scans up to `last_sequence`: sends again what it lacks, and
  // what it has not acknowledged.
  void Rewind(uint64_t last_sequence) {
    to_send_ = std::min(last_sequence, acked_) + 1;
    if (to_send_ < first()) to_send_ = first();
    at_server_ = last_sequence;
  }

 private:
  struct Entry {
    std::shared_ptr<T> scan;
    size_t bytes;
  };

  uint64_t first() const { return next_ - entries_.size(); }
  void PopFront() {
    acked_bytes_ -= entries_.front().bytes;
    entries_.pop_front();
    if (to_send_ < first()) to_send_ = first();
  }

  const size_t window_, spool_bytes_;
  uint64_t next_;       // The next scan to be added.
  uint64_t to_send_;    // The next scan to be sent.
  uint64_t acked_;      // All up to here are acknowledged.
  uint64_t at_server_;  // The server has all up to here.
  std::optional<uint64_t> sent_;
  size_t acked_bytes_ = 0;
  std::deque<Entry> entries_;  // The scans next_ - size() ... next_ - 1.
};

}  // namespace isthmus::client
