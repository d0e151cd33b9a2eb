// The scans that robots sent, kept beside the map so that it can be rebuilt from them.
#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "core/concurrency/mutex.h"
#include "core/ids.h"
#include "core/io/append_file.h"
#include "core/scan_upload.h"

namespace isthmus::storage {

struct ScanArchiveOptions {
  // A segment is not made larger by a further scan. Smaller ones let go of space in smaller steps;
  // larger ones are fewer files.
  uint64_t segment_bytes = 64u << 20;
  io::DiskCalls disk = io::DiskCalls::System();
};

// Appends to the segments in `directory`/scans/SESSION/. One process at a time: the holder of the
// map folder's lock. Thread safe; calls for one session wait for each other, those for different
// sessions do not.
//
// Errors are io::FileError's. After any of them the call can be made again: a record half written
// is taken back or is passed over by readers.
class ScanArchive {
 public:
  // Changes nothing on the disk: folders are made for the first scan.
  static absl::StatusOr<std::unique_ptr<ScanArchive>> Open(const std::string& directory,
                                                           const ScanArchiveOptions& options = {});
  ~ScanArchive();
  ScanArchive(const ScanArchive&) = delete;
  ScanArchive& operator=(const ScanArchive&) = delete;

  // Adds a scan behind the others. A sequence that was added before is no error: a reader takes it
  // once. The first call for a session cuts off the unfinished end of a process that died.
  absl::Status Append(const SessionId& session, const ScanUpload& scan);
  // Once this returns OK all that was appended survives the death of the machine. DataLoss when the
  // disk has lost scans that it had taken; it stays so until the archive is opened again.
  absl::Status Sync(const SessionId& session);
  // As Sync, and lets go of the session's file. Scans may follow all the same.
  absl::Status Finish(const SessionId& session);

  // All scans of the session. One that has none is no error.
  absl::Status Remove(const SessionId& session);
  // The session's first scans: those of its oldest segment. Returns the bytes that this frees; 0
  // when there are none left.
  absl::StatusOr<uint64_t> RemoveOldestSegment(const SessionId& session);

  // On the disk; 0 for a session without scans.
  uint64_t Bytes(const SessionId& session) const;

 private:
  class Session;

  ScanArchive(std::string folder, const ScanArchiveOptions& options);
  // Makes one where there is none.
  std::shared_ptr<Session> Find(const SessionId& session);

  const std::string folder_;
  const ScanArchiveOptions options_;
  mutable Mutex mutex_;
  std::map<SessionId, std::shared_ptr<Session>> sessions_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace isthmus::storage
