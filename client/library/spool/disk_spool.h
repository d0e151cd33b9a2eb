// The scans of one session on disk. Private to the library.
#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "client/library/spool/session_spool.h"
#include "client/library/spool/spool_segment.h"
#include "core/concurrency/mutex.h"

namespace isthmus::client {

// Sequences count from 1. Reading never waits for writing. Errors are io::FileError's.
class DiskSpool final : public SessionSpool {
 public:
  struct Options {
    uint64_t segment_bytes = 64u << 20;  // A file is closed when it is larger.
    // A scan is on the disk at most so much later than Append returns; 0: before it returns.
    double sync_interval_s = 0;
    const io::DiskCalls* disk = &io::DiskCalls::System();
  };

  // A new folder. Nothing is left of it on failure.
  static absl::StatusOr<std::unique_ptr<DiskSpool>> Create(const std::string& folder,
                                                           const SpoolIdentity& identity,
                                                           const Options& options);
  // Opens what an earlier program left. The half record at the end that a crash leaves is cut off.
  // DataLoss when it cannot be told whose scans they are.
  static absl::StatusOr<std::unique_ptr<DiskSpool>> Open(const std::string& folder,
                                                         const Options& options);

  SpoolIdentity identity() const override;
  absl::Status SetIdentity(const SpoolIdentity& identity) override;

  absl::StatusOr<uint64_t> Append(int64_t end_stamp_ns, std::string payload, double now_s) override;
  // Puts on the disk what sync_interval_s left.
  absl::Status Sync(double now_s) override;

  // Aborted where `from` is not the last that was written: a file holds the numbers of its scans.
  absl::Status Skip(uint64_t from, uint64_t sequence) override;

  absl::StatusOr<std::string> Read(uint64_t sequence) const override;
  std::optional<Entry> Find(uint64_t sequence) const override;
  int64_t StampBefore(uint64_t sequence) const override;

  uint64_t first() const override;
  uint64_t safe() const override;     // Up to here they are on the disk.
  uint64_t written() const override;  // Up to here they survive the death of the process.
  uint64_t bytes() const override;    // All files.

  // Removes the files of which no scan is above `durable`; the newest file stays.
  void Release(uint64_t durable, uint64_t acked) override;
  // Removes the oldest file, whatever is in it; its scans are lost. False when it is the only one.
  bool DropOldest() override;
  // Removes the folder, too.
  absl::Status Remove() override;

  std::vector<std::string> TakeNotes() override;

 private:
  struct Kept {
    io::Record scan;
    double appended_s = 0;
  };
  struct Part {
    std::shared_ptr<SpoolSegment> segment;
    std::vector<Kept> entries;  // By ascending sequence.
  };

  static bool IsBelow(const Kept& entry, uint64_t sequence) {
    return entry.scan.sequence < sequence;
  }
  DiskSpool(std::string folder, const SpoolIdentity& identity, const Options& options)
      : folder_(std::move(folder)), options_(options), identity_(identity) {}

  // As a constructor: nobody else has it yet.
  absl::Status Load() ABSL_NO_THREAD_SAFETY_ANALYSIS;
  absl::Status LoadPart(uint64_t first_sequence, bool newest) ABSL_NO_THREAD_SAFETY_ANALYSIS;
  std::string PathOf(uint64_t first_sequence) const;
  // The part that is written to; a new one where the last is full or cannot be trusted with more.
  absl::StatusOr<std::shared_ptr<SpoolSegment>> PartToWrite(double now_s)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(write_mutex_);
  absl::Status StartPart() ABSL_EXCLUSIVE_LOCKS_REQUIRED(write_mutex_);
  absl::StatusOr<uint64_t> Write(int64_t end_stamp_ns, const std::string& payload, double now_s)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(write_mutex_);
  // The disk is full: has the last file's scans go once they are durable. True if some went now.
  bool MakeWay(double now_s) ABSL_EXCLUSIVE_LOCKS_REQUIRED(write_mutex_);
  bool ReleaseFront() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  absl::Status SyncWritten(double now_s) ABSL_EXCLUSIVE_LOCKS_REQUIRED(write_mutex_);
  void RemoveFront() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  const std::string folder_;
  const Options options_;

  // Held while a scan is written and synced.
  Mutex write_mutex_ ABSL_ACQUIRED_BEFORE(mutex_);
  bool spoilt_ ABSL_GUARDED_BY(write_mutex_) = false;  // The last file failed.
  double synced_s_ ABSL_GUARDED_BY(write_mutex_) = -1e300;

  mutable Mutex mutex_;
  SpoolIdentity identity_ ABSL_GUARDED_BY(mutex_);
  // By ascending sequence, never empty; the last one is written to.
  std::deque<Part> parts_ ABSL_GUARDED_BY(mutex_);
  uint64_t written_ ABSL_GUARDED_BY(mutex_) = 0;
  uint64_t safe_ ABSL_GUARDED_BY(mutex_) = 0;
  uint64_t durable_ ABSL_GUARDED_BY(mutex_) = 0;  // As Release was told.
  uint64_t bytes_ ABSL_GUARDED_BY(mutex_) = 0;
  std::vector<std::string> notes_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace isthmus::client
