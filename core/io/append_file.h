// A file that only grows, by pieces that are in it wholly or not at all.
#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include <cstdint>
#include <memory>
#include <string>

namespace isthmus::io {

// Waits until what was written to a descriptor is on the disk; 0, or -1 with errno.
using SyncCall = int (*)(int descriptor);

// The names in a folder are on the disk only once it is synced itself.
absl::Status SyncFolder(const std::string& path, SyncCall sync);

// Errors are FileError's. Not thread safe.
class AppendFile {
 public:
  // Opens the file, or makes it where it is missing.
  static absl::StatusOr<std::unique_ptr<AppendFile>> Open(const std::string& path);
  // A file that is there; nothing can be appended.
  static absl::StatusOr<std::unique_ptr<AppendFile>> OpenToRead(const std::string& path);
  ~AppendFile();
  AppendFile(const AppendFile&) = delete;
  AppendFile& operator=(const AppendFile&) = delete;

  // On error the file is as it was before, or, where even that fails, is_broken().
  absl::Status Append(const std::string& bytes);
  absl::Status Truncate(uint64_t size);
  absl::Status Sync(SyncCall sync);
  // The bytes at that offset; shorter where the file ends.
  absl::StatusOr<std::string> Read(uint64_t offset, size_t size) const;

  const std::string& path() const { return path_; }
  uint64_t size() const { return size_; }
  uint64_t synced_size() const { return synced_size_; }  // Of which the last Sync made sure.
  // Ends with half a piece: nothing is to be appended.
  bool is_broken() const { return is_broken_; }
  // A Sync failed: whether the system still has what was written since the last is not known.
  bool is_suspect() const { return is_suspect_; }

 private:
  AppendFile(std::string path, int descriptor, uint64_t size);
  static absl::StatusOr<std::unique_ptr<AppendFile>> Open(const std::string& path, int flags);

  const std::string path_;
  const int descriptor_;
  uint64_t size_;
  uint64_t synced_size_;
  bool is_broken_ = false;
  bool is_suspect_ = false;
};

}  // namespace isthmus::io
