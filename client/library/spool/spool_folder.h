// The folder of a spool: a lock, and a sub-folder per session. Private to the library.
#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "client/library/spool/disk_spool.h"
#include "core/io/directory_lock.h"

namespace isthmus::client {

// Locked against other programs as long as it lives, however its process dies. Not thread safe.
class SpoolFolder {
 public:
  // FailedPrecondition when another program has it or it cannot be written to.
  static absl::StatusOr<std::unique_ptr<SpoolFolder>> Open(const std::string& path);

  // The sessions that earlier programs left, the oldest first. Errors as DiskSpool::Open.
  absl::StatusOr<std::vector<std::unique_ptr<DiskSpool>>> Load(const DiskSpool::Options& options);
  // For one more session.
  absl::StatusOr<std::unique_ptr<DiskSpool>> Add(const SpoolIdentity& identity,
                                                 const DiskSpool::Options& options);

 private:
  SpoolFolder(std::string path, std::unique_ptr<io::DirectoryLock> lock)
      : path_(std::move(path)), lock_(std::move(lock)) {}

  const std::string path_;
  const std::unique_ptr<io::DirectoryLock> lock_;
  uint64_t newest_ = 0;  // Number of the newest sub-folder.
};

}  // namespace isthmus::client
