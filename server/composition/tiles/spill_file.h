// The file for points that memory has no room for. It has no name and is gone when the process
// ends, however it ends. Nothing in it is needed after a restart.
#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include <cstddef>
#include <cstdint>
#include <string>

#include "core/concurrency/mutex.h"
#include "core/io/file_io.h"
#include "server/composition/tiles/extent_allocator.h"

namespace isthmus::composition {

// Thread safe.
class SpillFile {
 public:
  // Made in the folder when first written to. The file does not grow into the last `reserve_bytes`
  // of its disk: those are for what robots send, which has nowhere else to go.
  SpillFile(std::string folder, uint64_t reserve_bytes,
            const io::DiskCalls& disk = io::DiskCalls::System());

  // ResourceExhausted when the disk is full, Unavailable when it fails otherwise; the file is then
  // as before.
  absl::StatusOr<Extent> Write(const void* data, size_t size);
  // `size` bytes that begin `from` bytes into what was written; DataLoss when not all of them can
  // be read.
  absl::Status Read(const Extent& extent, uint64_t from, void* data, size_t size) const;
  // The space is used again.
  void Free(const Extent& extent);

  uint64_t bytes_in_use() const;

 private:
  absl::StatusOr<Extent> Allocate(size_t size);  // Opens the file, too.

  const std::string folder_;
  const uint64_t reserve_bytes_;
  const io::DiskCalls& disk_;
  mutable Mutex mutex_;
  io::File file_;  // Opened under the lock by the first Allocate, then left as it is.
  ExtentAllocator extents_ ABSL_GUARDED_BY(mutex_);
  uint64_t length_ ABSL_GUARDED_BY(mutex_) = 0;  // The file's length, at most.
};

}  // namespace isthmus::composition
