// Files: what an errno means, the system calls a disk may fail, whole files.
#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>
#include <sys/types.h>

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace isthmus::io {

// "why; what to do about it".
std::string Explain(int error);

// The meaning of errno, as "cannot ACTION PATH: why; what to do": NotFound, PermissionDenied,
// FailedPrecondition (a directory), ResourceExhausted (the disk is full) or Unavailable.
absl::Status FileError(const std::string& action, const std::string& path, int error);

// The space of a file system, for writers other than root.
struct DiskSpace {
  uint64_t free_bytes = 0, total_bytes = 0;
};
// The space of the file system that holds the folder; zeros if it does not tell.
DiskSpace SpaceOf(const std::string& folder);

// The system calls that may fail for want of a disk; tests put others in their place.
struct DiskCalls {
  std::function<ssize_t(int, const void*, size_t, off_t)> write;  // pwrite(2)
  std::function<ssize_t(int, void*, size_t, off_t)> read;         // pread(2)
  std::function<int(int)> sync;                                   // fdatasync(2)
  std::function<int(int)> sync_folder;                            // fsync(2)
  std::function<uint64_t(const std::string& folder)> free_bytes;  // statvfs(3), of its disk.

  static const DiskCalls& System();
  // For pipes and terminals, which have no places to read from and write to: offsets count for
  // nothing, and neither sync nor free_bytes is there.
  static const DiskCalls& Streams();
};

// An open file. Errors are FileError's. Thread safe as the system's calls are.
class File {
 public:
  File() = default;  // None.
  // Takes over a descriptor; `path` is what errors call it. The calls must outlive it.
  File(int descriptor, std::string path, const DiskCalls& disk);
  static absl::StatusOr<File> Open(const std::string& path, int flags,
                                   const DiskCalls& disk = DiskCalls::System());
  ~File();
  File(File&& other) noexcept;
  File& operator=(File&& other) noexcept;

  bool is_open() const { return descriptor_ >= 0; }
  int descriptor() const { return descriptor_; }
  const std::string& path() const { return path_; }

  absl::StatusOr<uint64_t> Size() const;
  absl::Status Write(const void* data, size_t size, uint64_t offset) const;  // All of it.
  // Returns how many bytes there are; fewer than `size` where the file ends.
  absl::StatusOr<size_t> Read(void* data, size_t size, uint64_t offset) const;
  absl::Status Truncate(uint64_t size) const;
  absl::Status Sync() const;  // The bytes written, and the file's end, are on the disk on return.
  absl::Status Close();       // Network file systems report a full disk only here.

 private:
  int descriptor_ = -1;
  std::string path_;
  const DiskCalls* disk_ = nullptr;
};

// Errors of FileError.
absl::StatusOr<std::string> ReadFile(const std::string& path);

// Replaces the file. Errors of FileError.
absl::Status WriteFile(const std::string& path, const std::string& bytes);

}  // namespace isthmus::io
