// A spill file that fails when told to.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "server/composition/spill_file.h"

namespace isthmus::composition {

class FailingSpillFile : public SpillFile {
 public:
  static constexpr uint64_t kReserve = 1 << 20;

  FailingSpillFile() : SpillFile(::testing::TempDir(), kReserve) {}

  std::atomic<size_t> longest = std::numeric_limits<size_t>::max();  // Bytes of one call.
  std::atomic<int> interrupt_every = 0;                              // Calls; 0: never.
  std::atomic<int> writes_left = std::numeric_limits<int>::max();    // Then the disk is full.
  std::atomic<bool> fail_reads = false;
  std::atomic<uint64_t> free_bytes = uint64_t{1} << 40;

 protected:
  ssize_t WriteSome(int file, const char* data, size_t size, uint64_t offset) override {
    if (Interrupted()) return -1;
    if (writes_left <= 0) {
      errno = ENOSPC;
      return -1;
    }
    --writes_left;
    return SpillFile::WriteSome(file, data, std::min(size, longest.load()), offset);
  }
  ssize_t ReadSome(int file, char* data, size_t size, uint64_t offset) const override {
    if (Interrupted()) return -1;
    if (fail_reads) {
      errno = EIO;
      return -1;
    }
    return SpillFile::ReadSome(file, data, std::min(size, longest.load()), offset);
  }
  uint64_t FreeDiskBytes() const override { return free_bytes; }

 private:
  bool Interrupted() const {
    if (interrupt_every == 0 || ++calls_ % interrupt_every != 0) return false;
    errno = EINTR;
    return true;
  }

  mutable std::atomic<int> calls_ = 0;
};

}  // namespace isthmus::composition
