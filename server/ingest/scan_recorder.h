// The recorder of raw scans: it archives them on their way in, and decides the consequence of a
// failure.
#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>

#include "core/codec/payload_layout.h"
#include "core/concurrency/mutex.h"
#include "core/ids.h"
#include "core/scan_upload.h"
#include "server/archive_options.h"
#include "storage/archive/scan_archive.h"

namespace isthmus::ingest {

// Thread safe.
class ScanRecorder {
 public:
  // With server::ArchiveMode::kOff scans that were kept earlier are still counted, and removed with
  // their sessions. Scans of more than `max_points`, which are rejected, are not kept. `on_problem`
  // is told once when keeping begins to fail.
  static absl::StatusOr<std::unique_ptr<ScanRecorder>> Open(
      const server::ArchiveOptions& options, std::function<void(const std::string&)> on_problem,
      uint64_t max_points = codec::kMaxScanPoints);

  // Keeps a scan before it is offered, if it is the next of the session: others are repeats, or
  // will be refused. `last_sequence`: the last that took effect. Errors, where the archive is
  // required: ResourceExhausted; the scan must not be taken then. A scan is kept even if the
  // odometry rejects it: better parameters may make more of it. A scan that cannot be decoded is
  // not: nothing ever will.
  absl::Status RecordScan(const SessionId& session, uint64_t last_sequence, const ScanUpload& scan);
  // Once this returns OK the kept scans survive; to be called before a result of the scans is
  // called durable.
  absl::Status Sync(const SessionId& session);
  // The same for the end of a session.
  absl::Status Finish(const SessionId& session);
  absl::Status Remove(const SessionId& session);
  // Removes the oldest scans of a finished session until `bytes` are free or none are left.
  absl::Status FreeBytes(const SessionId& session, uint64_t bytes);

  uint64_t Bytes(const SessionId& session) const;
  // The scans missing from the session's archive, for its status; empty when none are.
  std::string Problem(const SessionId& session) const;

 private:
  struct Kept {
    uint64_t last_sequence = 0;  // Last scan that was looked at.
    uint64_t missing = 0;        // Scans that could not be kept.
    std::string problem;
  };

  ScanRecorder(const server::ArchiveOptions& options,
               std::function<void(const std::string&)> on_problem,
               std::unique_ptr<storage::ScanArchive> archive, uint64_t max_points);
  bool IsWorthKeeping(const PointPayload& payload) const;
  bool keeps() const { return archive_ != nullptr && options_.mode != server::ArchiveMode::kOff; }
  // The consequence of the archive's answer: `status` where the archive is required, else a note.
  absl::Status FollowUp(const SessionId& session, const absl::Status& status, uint64_t missing);

  const server::ArchiveOptions options_;
  const std::function<void(const std::string&)> on_problem_;
  const uint64_t max_points_;
  const std::unique_ptr<storage::ScanArchive> archive_;  // Null without a directory.
  mutable Mutex mutex_;
  std::map<SessionId, Kept> kept_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace isthmus::ingest
