// One process per map folder.
#pragma once

#include <absl/status/statusor.h>

#include <memory>
#include <string>

namespace isthmus::storage {

// Held for as long as it lives; the kernel lets go of it when the process dies, however it does.
class DirectoryLock {
 public:
  // Makes the folder if need be and locks `directory`/isthmus.lock, which holds the number of the
  // process. FailedPrecondition when another holder has it or the folder cannot be written to,
  // Unavailable when it cannot be made.
  static absl::StatusOr<std::unique_ptr<DirectoryLock>> Take(const std::string& directory);
  ~DirectoryLock();
  DirectoryLock(const DirectoryLock&) = delete;
  DirectoryLock& operator=(const DirectoryLock&) = delete;

 private:
  explicit DirectoryLock(int descriptor) : descriptor_(descriptor) {}

  const int descriptor_;
};

}  // namespace isthmus::storage
