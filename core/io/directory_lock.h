// One process per map folder.
#pragma once

#include <absl/status/statusor.h>

#include <memory>
#include <string>

namespace isthmus::io {

// Held for as long as it lives; the kernel lets go of it when the process dies, however it does.
class DirectoryLock {
 public:
  // Makes the folder if need be and locks `directory`/isthmus.lock, which holds the number of the
  // process. FailedPrecondition when another holder has it or the folder cannot be written to,
  // Unavailable when it cannot be made.
  static absl::StatusOr<std::unique_ptr<DirectoryLock>> Take(const std::string& directory);
  // As Take, to read only: makes and writes nothing. A folder without isthmus.lock is not locked,
  // as no process ever had it.
  static absl::StatusOr<std::unique_ptr<DirectoryLock>> TakeExisting(const std::string& directory);
  ~DirectoryLock();
  DirectoryLock(const DirectoryLock&) = delete;
  DirectoryLock& operator=(const DirectoryLock&) = delete;

 private:
  explicit DirectoryLock(int descriptor) : descriptor_(descriptor) {}

  const int descriptor_;  // -1: there was nothing to lock.
};

}  // namespace isthmus::io
