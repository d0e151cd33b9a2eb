// A disk that fails as told.
#pragma once

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <optional>

#include "core/io/file_io.h"

namespace isthmus::io {

// Has room for so many bytes more, cannot read some, or its fsync fails.
class FailingDisk {
 public:
  std::optional<size_t> room;  // Absent: as much as there is.
  bool fails_to_sync = false;
  int syncs = 0;
  off_t bad_from = 0, bad_to = 0;  // Bytes of every file that cannot be read.

  FailingDisk() = default;
  FailingDisk(const FailingDisk&) = delete;
  FailingDisk& operator=(const FailingDisk&) = delete;

  const DiskCalls& calls() const { return calls_; }

 private:
  ssize_t Write(int file, const void* data, size_t size, off_t offset) {
    if (!room) return pwrite(file, data, size, offset);
    const size_t fits = std::min(size, *room);
    *room -= fits;
    if (fits > 0) return pwrite(file, data, fits, offset);
    errno = ENOSPC;
    return -1;
  }
  ssize_t Read(int file, void* data, size_t size, off_t offset) const {
    if (offset >= bad_to || offset + static_cast<off_t>(size) <= bad_from) {
      return pread(file, data, size, offset);
    }
    errno = EIO;
    return -1;
  }
  int Sync(int file) {
    ++syncs;
    if (!fails_to_sync) return fdatasync(file);
    errno = EIO;
    return -1;
  }

  const DiskCalls calls_{.write = [this](int file, const void* data, size_t size,
                                         off_t offset) { return Write(file, data, size, offset); },
                         .read = [this](int file, void* data, size_t size,
                                        off_t offset) { return Read(file, data, size, offset); },
                         .sync = [this](int file) { return Sync(file); },
                         .sync_folder = fsync,
                         .free_bytes = DiskCalls::System().free_bytes};
};

}  // namespace isthmus::io
