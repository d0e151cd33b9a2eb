// A tile: the points of one square of one component's map; and where tiles keep their points.
#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <set>
#include <utility>
#include <vector>

#include "core/cloud.h"
#include "core/concurrency/mutex.h"
#include "core/lru_cache.h"
#include "server/composition/box_fields.h"
#include "server/composition/tiles/map_file.h"
#include "server/composition/tiles/tile_point.h"

namespace isthmus::composition {

class Tile;
using TilePtr = std::shared_ptr<const Tile>;
class TileCache;

// All of a tile but its points.
struct TileRecord {
  int32_t x = 0, y = 0;         // TileKey's.
  std::vector<TilePart> parts;  // In order of the robots' ids; none is empty.
  Box bounds;                   // Map frame, exact.
  uint64_t version = 0;         // As TileInfo's.
  int64_t revision = 0;         // As TileInfo's.

  uint32_t point_count() const { return parts.empty() ? 0 : parts.back().end(); }

  // For state_codec.h.
  template <typename Self, typename Io>
  static void Fields(Self& self, Io& io) {
    io(self.x, self.y, self.parts, self.bounds, self.version, self.revision);
  }
};

struct TileContent {
  TileRecord record;
  std::vector<TilePoint> points;  // Part by part.
};

// Points of a tile, and the range of each part.
struct TilePoints {
  std::shared_ptr<const std::vector<TilePoint>> points;
  std::vector<std::pair<uint32_t, uint32_t>> ranges;  // [begin, end) of each of the tile's parts.
};

// Immutable; shared between the maps of many revisions. Its points are in memory, in the map's
// file, or both. Thread safe.
class Tile : public std::enable_shared_from_this<Tile> {
 public:
  // For TileCache, which makes them.
  Tile(std::shared_ptr<TileCache> cache, TileRecord record);
  ~Tile();
  Tile(const Tile&) = delete;
  Tile& operator=(const Tile&) = delete;

  const TileRecord& record() const { return record_; }
  const std::vector<TilePart>& parts() const { return record_.parts; }
  const Box& bounds() const { return record_.bounds; }
  uint64_t point_count() const { return record_.point_count(); }
  // The points of a level of detail, see TilePart::EndOf. Reads no others from the file.
  // Unavailable where they cannot be read back: the cache's owner makes the tile again.
  absl::StatusOr<TilePoints> Points(uint32_t level = 0) const;

 private:
  friend class TileCache;

  const std::shared_ptr<TileCache> cache_;
  const TileRecord record_;
  // Size 0 while the points are in memory only. Owned by the cache; for TileCache::ExtentOf alone.
  mutable Extent extent_;
};

// Keeps the points of all tiles there are, of which `max_bytes` in memory, about. Thread safe but
// for Add and KeepToMemory, which one thread calls.
class TileCache : public std::enable_shared_from_this<TileCache> {
 public:
  // Without a file all stays in memory.
  TileCache(std::shared_ptr<MapFile> file, size_t max_bytes);

  TilePtr Add(TileContent content);
  // A tile whose points the file has, as WhereIs said.
  TilePtr Restore(TileRecord record, const Extent& extent);
  // Size 0: not in the file.
  Extent WhereIs(const Tile& tile) const;
  // After it the points of all tiles are in the file, too; there must be one. Called as
  // KeepToMemory is, and fails as that does.
  absl::Status WriteAll();
  // Writes to the file what is asked for least, if the limit is exceeded. Fails as MapFile::Write
  // does: no point is lost then, but the limit is not kept.
  absl::Status KeepToMemory();

  // Tiles whose points could not be read back, since the last call. Only to be compared: some may
  // be gone by now.
  std::set<const Tile*> TakeLost();
  bool has_lost() const;
  // Calls `on_lost` whenever there is one, from the thread that reads; null: nobody any more, once
  // this returns.
  void TellLost(std::function<void()> on_lost);

  size_t bytes_in_memory() const;

 private:
  friend class Tile;

  using Held = std::shared_ptr<const std::vector<TilePoint>>;
  using Points = LruCache<const Tile*, Held>;

  // Null, and where it lies, of a tile that is in the file only.
  std::pair<Held, Extent> Find(const Tile& tile);
  absl::StatusOr<Held> ReadWhole(const Tile& tile, const Extent& extent);
  absl::StatusOr<TilePoints> PointsOf(const Tile& tile, uint32_t level);
  void Forget(const Tile& tile);
  absl::Status NoteLost(const Tile& tile, const absl::Status& why);
  absl::Status SavePoints(const TilePtr& tile, const Held& points);
  // Writes points until no more than so many bytes of them are in memory only.
  absl::Status SaveDownTo(size_t unsaved_bytes);
  // The tile to write to the file next, with its points; none once enough are written.
  std::pair<TilePtr, Held> NextToSave(size_t unsaved_bytes);
  void DropSaved() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  Extent& ExtentOf(const Tile& tile) const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    return tile.extent_;
  }

  const std::shared_ptr<MapFile> file_;
  const size_t max_bytes_;
  mutable Mutex mutex_;
  Points unsaved_ ABSL_GUARDED_BY(mutex_);  // In memory only.
  Points saved_ ABSL_GUARDED_BY(mutex_);    // In the file too.
  std::set<const Tile*> lost_ ABSL_GUARDED_BY(mutex_);
  Mutex telling_;  // Held while on_lost_ is called.
  std::function<void()> on_lost_ ABSL_GUARDED_BY(telling_);
};

}  // namespace isthmus::composition
