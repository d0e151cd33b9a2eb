#include "server/composition/tiles/extent_allocator.h"

#include <algorithm>
#include <iterator>

namespace isthmus::composition {

std::optional<ExtentAllocator> ExtentAllocator::Of(std::vector<Extent> in_use) {
  std::ranges::sort(in_use, {}, &Extent::offset);
  ExtentAllocator extents;
  for (const Extent& extent : in_use) {
    const bool is_whole = extent.size > 0 && extent.size % kGrain == 0 &&
                          extent.offset % kGrain == 0 &&
                          extent.offset + extent.size > extent.offset;
    if (!is_whole || extent.offset < extents.end_) return std::nullopt;
    if (extent.offset > extents.end_) {
      extents.Insert(extents.end_, extent.offset - extents.end_);
    }
    extents.end_ = extent.offset + extent.size;
    extents.in_use_ += extent.size;
  }
  return extents;
}

Extent ExtentAllocator::Allocate(uint64_t size) {
  size = (size + kGrain - 1) / kGrain * kGrain;
  if (size == 0) return {};
  in_use_ += size;
  const auto fit = by_size_.lower_bound({size, 0});
  if (fit == by_size_.end()) {
    end_ += size;
    return {end_ - size, size};
  }
  const auto [found, offset] = *fit;
  Remove(free_.find(offset));
  if (found > size) Insert(offset + size, found - size);
  return {offset, size};
}

void ExtentAllocator::Free(const Extent& extent) {
  if (extent.size == 0) return;
  in_use_ -= extent.size;
  uint64_t begin = extent.offset, end = extent.offset + extent.size;
  const auto next = free_.lower_bound(begin);
  if (next != free_.begin()) {
    const auto before = std::prev(next);
    if (before->first + before->second == begin) {
      begin = before->first;
      Remove(before);
    }
  }
  if (next != free_.end() && next->first == end) {
    end += next->second;
    Remove(next);
  }
  if (end == end_) {
    end_ = begin;
  } else {
    Insert(begin, end - begin);
  }
}

void ExtentAllocator::Insert(uint64_t offset, uint64_t size) {
  free_[offset] = size;
  by_size_.insert({size, offset});
}

void ExtentAllocator::Remove(std::map<uint64_t, uint64_t>::iterator it) {
  by_size_.erase({it->second, it->first});
  free_.erase(it);
}

}  // namespace isthmus::composition
