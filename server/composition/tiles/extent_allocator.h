// An allocator of extents of a file.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <utility>
#include <vector>

namespace isthmus::composition {

// A part of a file, in bytes; none if size is 0.
struct Extent {
  uint64_t offset = 0, size = 0;

  // For state_codec.h.
  template <typename Self, typename Io>
  static void Fields(Self& self, Io& io) {
    io(self.offset, self.size);
  }
};

// Best fit; what is given back joins its neighbours. Not thread safe.
class ExtentAllocator {
 public:
  // Sizes are rounded up to this.
  static constexpr uint64_t kGrain = 4096;

  // With these in use; nothing if they overlap or Allocate gave none of their like.
  static std::optional<ExtentAllocator> Of(std::vector<Extent> in_use);

  // From what was given back if that has a stretch of this size, else behind the end.
  Extent Allocate(uint64_t size);
  // Must have come from Allocate, whole.
  void Free(const Extent& extent);

  uint64_t end() const { return end_; }  // End of the last stretch in use.
  uint64_t in_use() const { return in_use_; }

 private:
  void Insert(uint64_t offset, uint64_t size);
  void Remove(std::map<uint64_t, uint64_t>::iterator it);

  std::map<uint64_t, uint64_t> free_;                // Offset to size; no two touch.
  std::set<std::pair<uint64_t, uint64_t>> by_size_;  // The same: size, offset.
  uint64_t end_ = 0;
  uint64_t in_use_ = 0;
};

}  // namespace isthmus::composition
