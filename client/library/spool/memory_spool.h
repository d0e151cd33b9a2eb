// The scans of one session in memory. Private to the library.
#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <string>

#include "client/library/spool/session_spool.h"
#include "core/concurrency/mutex.h"

namespace isthmus::client {

// Scans without acknowledgement are never given up; of the others the oldest are once all take more
// than `most_bytes`.
class MemorySpool final : public SessionSpool {
 public:
  // The first scan gets the number after `last_sequence`.
  MemorySpool(const SpoolIdentity& identity, uint64_t last_sequence, uint64_t most_bytes)
      : most_bytes_(most_bytes), identity_(identity), first_(last_sequence + 1) {}

  SpoolIdentity identity() const override;
  absl::Status SetIdentity(const SpoolIdentity& identity) override;
  absl::StatusOr<uint64_t> Append(int64_t end_stamp_ns, std::string payload, double now_s) override;
  absl::Status Sync(double) override { return absl::OkStatus(); }
  absl::Status Skip(uint64_t from, uint64_t sequence) override;
  absl::StatusOr<std::string> Read(uint64_t sequence) const override;
  std::optional<Entry> Find(uint64_t sequence) const override;
  int64_t StampBefore(uint64_t sequence) const override;
  uint64_t first() const override;
  uint64_t safe() const override { return written(); }
  uint64_t written() const override;
  uint64_t bytes() const override;
  void Release(uint64_t durable, uint64_t acked) override;
  absl::Status Remove() override;

 private:
  struct Scan {
    int64_t end_stamp_ns;
    std::string payload;
    double appended_s;
  };

  // Null when it is not kept.
  const Scan* Get(uint64_t sequence) const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  const uint64_t most_bytes_;
  mutable Mutex mutex_;
  SpoolIdentity identity_ ABSL_GUARDED_BY(mutex_);
  uint64_t first_ ABSL_GUARDED_BY(mutex_);
  int64_t stamp_before_ns_ ABSL_GUARDED_BY(mutex_) = 0;  // The scan before the first; 0: none.
  std::deque<Scan> scans_ ABSL_GUARDED_BY(mutex_);       // The scans first_, first_ + 1, ...
  uint64_t bytes_ ABSL_GUARDED_BY(mutex_) = 0;
};

}  // namespace isthmus::client
