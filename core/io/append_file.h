// A file that only grows, by pieces that are in it wholly or not at all.
#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include <cstdint>
#include <memory>
#include <string>

#include "core/io/file_io.h"

namespace isthmus::io {

// Errors are FileError's. Not thread safe but for Read, which may be called at the same time as
// anything.
class AppendFile {
 public:
  // Opens the file, or makes it where it is missing. The calls must outlive it.
  static absl::StatusOr<std::unique_ptr<AppendFile>> Open(
      const std::string& path, const DiskCalls& disk = DiskCalls::System());
  // A file that is there; nothing can be appended.
  static absl::StatusOr<std::unique_ptr<AppendFile>> OpenToRead(const std::string& path);

  // On error the file is as it was before, or, where even that fails, is_broken().
  absl::Status Append(const std::string& bytes);
  absl::Status Truncate(uint64_t size);
  absl::Status Sync();
  // The bytes at that offset; shorter where the file ends.
  absl::StatusOr<std::string> Read(uint64_t offset, size_t size) const;

  const std::string& path() const { return file_.path(); }
  uint64_t size() const { return size_; }
  uint64_t synced_size() const { return synced_size_; }  // The last Sync made sure of these bytes.
  // Ends with half a piece, which the next one overwrites, if there is one.
  bool is_broken() const { return is_broken_; }
  // A Sync failed: it is not known if the system still has the bytes written since the last.
  bool is_suspect() const { return is_suspect_; }

 private:
  AppendFile(File file, uint64_t size);
  static absl::StatusOr<std::unique_ptr<AppendFile>> Open(const std::string& path, int flags,
                                                          const DiskCalls& disk);

  const File file_;
  uint64_t size_;
  // The contents of a file that is opened survived so far, but might not survive a power cut now.
  uint64_t synced_size_ = 0;
  bool is_broken_ = false;
  bool is_suspect_ = false;
};

}  // namespace isthmus::io
