// A spill file that fails when told to.
#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>

#include "server/composition/tiles/map_file.h"

namespace isthmus::composition {

class FailingMapFile : public MapFile {
 public:
  static constexpr uint64_t kReserve = 1 << 20;

  explicit FailingMapFile(const std::string& folder = ::testing::TempDir())
      : MapFile(folder, kReserve, calls_) {}

  std::atomic<size_t> longest = std::numeric_limits<size_t>::max();  // Bytes of one call.
  std::atomic<int> interrupt_every = 0;                              // Calls; 0: never.
  std::atomic<int> writes_left = std::numeric_limits<int>::max();    // Then the disk is full.
  std::atomic<bool> fail_reads = false;
  std::atomic<uint64_t> free_bytes = uint64_t{1} << 40;
  mutable std::atomic<uint64_t> bytes_read = 0;

 private:
  ssize_t WriteSome(int file, const void* data, size_t size, off_t offset) {
    if (Interrupted()) return -1;
    if (writes_left <= 0) {
      errno = ENOSPC;
      return -1;
    }
    --writes_left;
    return pwrite(file, data, std::min(size, longest.load()), offset);
  }
  ssize_t ReadSome(int file, void* data, size_t size, off_t offset) const {
    if (Interrupted()) return -1;
    if (fail_reads) {
      errno = EIO;
      return -1;
    }
    const ssize_t read = pread(file, data, std::min(size, longest.load()), offset);
    if (read > 0) bytes_read += static_cast<uint64_t>(read);
    return read;
  }
  bool Interrupted() const {
    if (interrupt_every == 0 || ++count_ % interrupt_every != 0) return false;
    errno = EINTR;
    return true;
  }

  mutable std::atomic<int> count_ = 0;
  const io::DiskCalls calls_{
      .write = [this](int file, const void* data, size_t size,
                      off_t offset) { return WriteSome(file, data, size, offset); },
      .read = [this](int file, void* data, size_t size,
                     off_t offset) { return ReadSome(file, data, size, offset); },
      .sync = fdatasync,
      .sync_folder = fsync,
      .free_bytes = [this](const std::string&) { return free_bytes.load(); }};
};

}  // namespace isthmus::composition
