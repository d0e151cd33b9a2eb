// One process per folder.
#pragma once

#include <absl/status/statusor.h>

#include <memory>
#include <string>
#include <utility>

#include "core/io/file_io.h"

namespace isthmus::io {

// A kind of folder: the file in it that names the holder, and what a person calls it.
struct LockKind {
  std::string file = "isthmus.lock";
  std::string name = "the map folder";
};

// Held for as long as it lives; the kernel lets go of it when the process dies, however it does.
class DirectoryLock {
 public:
  // Makes the folder if need be and locks it and its file, which holds the number of the process.
  // FailedPrecondition when another holder has it or the folder cannot be made or written to.
  static absl::StatusOr<std::unique_ptr<DirectoryLock>> Acquire(const std::string& directory,
                                                                const LockKind& kind = {});
  // As Acquire of a map folder, to read only: makes and writes nothing.
  static absl::StatusOr<std::unique_ptr<DirectoryLock>> TakeExisting(const std::string& directory);

 private:
  DirectoryLock(File itself, File file) : itself_(std::move(itself)), file_(std::move(file)) {}

  const File itself_;  // The folder: whoever removes the file lets nobody in.
  const File file_;    // None: there was nothing to lock. Older programs look at nothing else.
};

}  // namespace isthmus::io
