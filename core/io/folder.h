// Folders whose names survive a power cut.
#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include <cstdint>
#include <string>
#include <vector>

#include "core/io/file_io.h"

namespace isthmus::io {

// Errors of all are FileError's.

// The names in a folder are on the disk only once it is synced itself. "" is the current one.
absl::Status SyncFolder(const std::string& path, const DiskCalls& disk = DiskCalls::System());
// The same of the folder that the file or folder lies in.
absl::Status SyncNameOf(const std::string& path);

// Makes the folder, and those above it, where there is none; they survive a power cut.
absl::Status MakeFolder(const std::string& path, const DiskCalls& disk = DiskCalls::System());

// The numbers N of what is called N`suffix` in it, ascending; no 0.
absl::StatusOr<std::vector<uint64_t>> ListNumbers(const std::string& folder,
                                                  const std::string& suffix);

// Becomes its target, or goes again.
class PartFolder {
 public:
  // Takes over a folder that is there, beside the target.
  explicit PartFolder(std::string path) : path_(std::move(path)) {}
  ~PartFolder();
  PartFolder(const PartFolder&) = delete;
  PartFolder& operator=(const PartFolder&) = delete;

  const std::string& path() const { return path_; }
  // All files in it must be synced.
  absl::Status Become(const std::string& target);

 private:
  std::string path_;  // Empty once it became its target.
};

}  // namespace isthmus::io
