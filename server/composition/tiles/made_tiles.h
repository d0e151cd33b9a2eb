// A cache of tiles of higher levels, made on demand and kept for all readers.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "core/cloud.h"
#include "core/concurrency/mutex.h"
#include "core/lru_cache.h"

namespace isthmus::composition {

// A tile of one content, of any map and component.
struct MadeTileKey {
  uint32_t level = 0;
  int32_t x = 0, y = 0;
  uint64_t version = 0;

  friend bool operator==(const MadeTileKey&, const MadeTileKey&) = default;
};

}  // namespace isthmus::composition

template <>
struct std::hash<isthmus::composition::MadeTileKey> {
  size_t operator()(const isthmus::composition::MadeTileKey& key) const {
    // A version is a hash already; tiles that share one differ in level.
    return key.version ^ key.level;
  }
};

namespace isthmus::composition {

// Full, it drops what was asked for longest ago. Thread safe.
class MadeTiles {
 public:
  // Points, with the composer's own numbers of robots.
  using Points = std::shared_ptr<const std::vector<MapPoint>>;

  explicit MadeTiles(size_t max_bytes) : max_bytes_(max_bytes) {}

  // Null where it is not there.
  Points Find(const MadeTileKey& key) {
    MutexLock lock(&mutex_);
    const Points* found = tiles_.Use(key);
    return found != nullptr ? *found : nullptr;
  }
  void Put(const MadeTileKey& key, Points points) {
    const size_t bytes = points->size() * sizeof(MapPoint);
    MutexLock lock(&mutex_);
    tiles_.Put(key, std::move(points), bytes);
    while (tiles_.weight() > max_bytes_) tiles_.DropOldest();
  }
  size_t bytes() const {
    MutexLock lock(&mutex_);
    return tiles_.weight();
  }

 private:
  const size_t max_bytes_;
  mutable Mutex mutex_;
  LruCache<MadeTileKey, Points> tiles_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace isthmus::composition
