// A cache of thinned submaps for the composer: in memory, in the map's file, or both.
#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <span>
#include <vector>

#include "core/ids.h"
#include "core/lru_cache.h"
#include "server/composition/tiles/map_file.h"
#include "server/composition/tiles/points_by_tile.h"

namespace isthmus::composition {

// Not thread safe.
class ThinnedSubmapCache {
 public:
  // Without a file all stays in memory.
  ThinnedSubmapCache(std::shared_ptr<MapFile> file, size_t max_bytes);
  ~ThinnedSubmapCache();
  ThinnedSubmapCache(const ThinnedSubmapCache&) = delete;
  ThinnedSubmapCache& operator=(const ThinnedSubmapCache&) = delete;

  // Keeps a submap's thinned points and which of them lie on which tile, instead of what was kept
  // under the id before.
  void Put(const SubmapId& id, std::vector<WeightedPoint> points, PointsByTile by_tile);
  void Erase(const SubmapId& id);
  // The points in the order in which they were put. Erases them, even if they cannot be read, which
  // fails as MapFile::Read does. The id must be there.
  absl::StatusOr<std::vector<WeightedPoint>> TakeOut(const SubmapId& id);

  // Points of which some, named by runs, lie on a tile.
  struct Piece {
    const std::vector<WeightedPoint>* points = nullptr;
    std::span<const PointRun> runs;
  };
  // The points on a submap's tile-th tile, valid until the next call of anything. Takes from the
  // file no more than these points. Fails as MapFile::Read does. The id must be there.
  absl::StatusOr<Piece> PieceOf(const SubmapId& id, size_t tile);

  // Lets `change` work on all points of a submap at once, in whatever order they stand; it must not
  // move any. Gives the tiles, by number, on which a point is gone now that was not, or is back.
  // The id must be there. Fails as MapFile does: what lay in the file is then as before.
  absl::StatusOr<std::vector<size_t>> Change(
      const SubmapId& id, const std::function<void(std::span<WeightedPoint>)>& change);

  // Moves to the file what was asked for longest ago, until the limit is kept. Fails as
  // MapFile::Write does: nothing is lost then.
  absl::Status KeepToMemory();
  // After it all of them are in the file, too; there must be one.
  absl::Status WriteAll();
  // Their places in the file, once all are there.
  std::vector<Extent> extents() const;

  // For state_codec.h: what was written, in whose place it is read.
  template <typename Self, typename Io>
  static void Fields(Self& self, Io& io) {
    io(self.entries_);
  }

  size_t bytes_in_memory() const { return in_memory_.weight(); }

 private:
  // A submap in memory or in the file. There, points stand tile by tile, so that those of a tile
  // are read at once, then those on no tile; then the runs, which tell the order they had.
  struct Entry {
    std::vector<WeightedPoint> points;  // Empty when not in memory.
    std::vector<PointRun> runs;         // Empty when not in memory.
    std::vector<uint32_t> first_run;    // PointsByTile::begin.
    Extent extent;                      // Size 0 when not in the file.
    std::vector<uint32_t> first_point;  // Each tile's first in the file, and the last tile's end.
    uint32_t point_count = 0;

    template <typename Self, typename Io>
    static void Fields(Self& self, Io& io) {
      io(self.first_run, self.extent, self.first_point, self.point_count);
    }
    size_t bytes() const {
      return points.capacity() * sizeof(WeightedPoint) + runs.capacity() * sizeof(PointRun);
    }
  };

  absl::Status ChangeInFile(Entry* entry,
                            const std::function<void(std::span<WeightedPoint>)>& change,
                            std::vector<size_t>* tiles);
  absl::Status WriteToFile(Entry* entry);
  void FreeExtent(Entry* entry);

  const std::shared_ptr<MapFile> file_;
  const size_t max_bytes_;
  std::map<SubmapId, Entry> entries_;
  LruCache<SubmapId, Entry*> in_memory_;
  std::vector<WeightedPoint> piece_;  // Read last.
  PointRun piece_run_;
};

}  // namespace isthmus::composition
