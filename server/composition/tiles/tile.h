// A tile: the points of one square of one component's map; and where tiles keep their points.
#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "core/cloud.h"
#include "core/concurrency/mutex.h"
#include "core/lru_cache.h"
#include "server/composition/tiles/spill_file.h"

namespace isthmus::composition {

class Tile;
using TilePtr = std::shared_ptr<const Tile>;
class TileCache;

// Points of one robot: [begin, end) of the tile's.
struct TilePart {
  uint32_t robot = 0;  // The composer's own number of a robot; never reused.
  uint32_t begin = 0, end = 0;
};

struct TileContent {
  std::vector<TilePart> parts;  // In order of the robots' ids; none is empty.
  Cloud points;                 // Map frame.
  Box bounds;                   // Map frame, exact.
};

// Immutable; shared between the maps of many revisions. Its points are in memory or in the spill
// file. Thread safe.
class Tile : public std::enable_shared_from_this<Tile> {
 public:
  // For TileCache, which makes them.
  Tile(std::shared_ptr<TileCache> cache, std::vector<TilePart> parts, const Box& bounds,
       uint64_t point_count);
  ~Tile();
  Tile(const Tile&) = delete;
  Tile& operator=(const Tile&) = delete;

  const std::vector<TilePart>& parts() const { return parts_; }
  const Box& bounds() const { return bounds_; }
  uint64_t point_count() const { return point_count_; }
  // Fails as SpillFile::Read does.
  absl::StatusOr<std::shared_ptr<const Cloud>> Points() const;

 private:
  friend class TileCache;

  const std::shared_ptr<TileCache> cache_;
  const std::vector<TilePart> parts_;
  const Box bounds_;
  const uint64_t point_count_;
  // Of size 0 while the points are in memory only. The cache's; for TileCache::ExtentOf alone.
  mutable Extent extent_;
};

// Keeps the points of all tiles there are, of which `max_bytes` in memory, about. Thread safe but
// for Add and KeepToMemory, which one thread calls.
class TileCache : public std::enable_shared_from_this<TileCache> {
 public:
  // Without a file all stays in memory.
  TileCache(std::shared_ptr<SpillFile> file, size_t max_bytes);

  TilePtr Add(TileContent content);
  // Writes to the file what is asked for least, if the limit is exceeded. Fails as SpillFile::Write
  // does: no point is lost then, but the limit is not kept.
  absl::Status KeepToMemory();

  size_t bytes_in_memory() const;

 private:
  friend class Tile;

  using Points = LruCache<const Tile*, std::shared_ptr<const Cloud>>;

  absl::StatusOr<std::shared_ptr<const Cloud>> PointsOf(const Tile& tile);
  void Forget(const Tile& tile);
  absl::Status SavePoints(const TilePtr& tile, const std::shared_ptr<const Cloud>& points);
  // The tile to write to the file next, with its points; none once enough are written.
  std::pair<TilePtr, std::shared_ptr<const Cloud>> NextToSave();
  void DropSaved() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  Extent& ExtentOf(const Tile& tile) const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    return tile.extent_;
  }

  const std::shared_ptr<SpillFile> file_;
  const size_t max_bytes_;
  mutable Mutex mutex_;
  Points unsaved_ ABSL_GUARDED_BY(mutex_);  // In memory only.
  Points saved_ ABSL_GUARDED_BY(mutex_);    // In the file too.
};

}  // namespace isthmus::composition
