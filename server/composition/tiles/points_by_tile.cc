#include "server/composition/tiles/points_by_tile.h"

#include <absl/container/flat_hash_map.h>

#include <algorithm>
#include <numeric>

#include "server/composition/placer.h"
#include "server/composition/tiles/tile_limit.h"

namespace isthmus::composition {
namespace {

// Numbers tiles in the order in which they are met. A submap lies on few tiles, and neighbours in
// it mostly on one: most of the time there is nothing to look up.
class TileNumbers {
 public:
  uint32_t Find(const TileKey& tile) {
    if (last_ < tiles_.size() && tiles_[last_] == tile) return last_;
    const auto [it, is_new] = numbers_.try_emplace(tile, static_cast<uint32_t>(tiles_.size()));
    if (is_new) tiles_.push_back(tile);
    last_ = it->second;
    return last_;
  }
  const std::vector<TileKey>& tiles() const { return tiles_; }

 private:
  absl::flat_hash_map<TileKey, uint32_t> numbers_;
  std::vector<TileKey> tiles_;
  uint32_t last_ = 0;
};

// A run and the number of its tile.
struct NumberedRun {
  uint32_t number = 0;
  PointRun run;
};

// False when told to end.
bool FindRuns(const std::vector<WeightedPoint>& points, const Placer& place, const VoxelGrid& grid,
              const TileLayout& layout, uint32_t frame, const KeepOn& keep_on, TileNumbers* numbers,
              std::vector<NumberedRun>* runs) {
  for (uint32_t i = 0; i < points.size(); ++i) {
    if (EndsAt(i, keep_on)) return false;
    const Eigen::Vector3f at = place(points[i]);
    const auto voxel = grid.Find(at.x(), at.y(), at.z());
    if (!voxel) continue;
    const uint32_t number = numbers->Find(layout.Find(frame, *voxel));
    if (runs->empty() || runs->back().number != number || runs->back().run.end != i) {
      runs->push_back({number, {i, i}});
    }
    runs->back().run.end = i + 1;
  }
  return true;
}

// The numbers of the tiles with at least so many points, in order of the tiles.
std::vector<uint32_t> NumbersToKeep(const std::vector<TileKey>& tiles,
                                    const std::vector<uint64_t>& point_count, uint64_t fewest) {
  std::vector<uint32_t> keep;
  for (uint32_t number = 0; number < tiles.size(); ++number) {
    if (point_count[number] >= fewest) keep.push_back(number);
  }
  std::sort(keep.begin(), keep.end(), [&](uint32_t l, uint32_t r) { return tiles[l] < tiles[r]; });
  return keep;
}

// Lays out runs by tile, in one pass over them: `keep` says which tiles, in which order.
void LayOut(const std::vector<NumberedRun>& runs, const std::vector<uint32_t>& keep,
            size_t tile_count, PointsByTile* sorted) {
  constexpr uint32_t kLeftOut = ~uint32_t{0};
  std::vector<uint32_t> place_of(tile_count, kLeftOut);
  for (uint32_t i = 0; i < keep.size(); ++i) place_of[keep[i]] = i;
  std::vector<uint32_t> next(keep.size() + 1);
  for (const NumberedRun& run : runs) {
    if (place_of[run.number] != kLeftOut) ++next[place_of[run.number]];
  }
  std::exclusive_scan(next.begin(), next.end(), next.begin(), uint32_t{0});
  sorted->begin = next;
  sorted->runs.resize(next.back());
  for (const NumberedRun& run : runs) {
    const uint32_t place = place_of[run.number];
    if (place != kLeftOut) sorted->runs[next[place]++] = run.run;
  }
}

}  // namespace

std::optional<PointsByTile> SortByTile(const std::vector<WeightedPoint>& points, uint32_t frame,
                                       const Pose& T_map_submap, const VoxelGrid& grid,
                                       const TileLayout& layout, size_t max_tiles,
                                       const KeepOn& keep_on) {
  TileNumbers numbers;
  std::vector<NumberedRun> runs;
  if (!FindRuns(points, Placer(T_map_submap), grid, layout, frame, keep_on, &numbers, &runs)) {
    return std::nullopt;
  }
  const std::vector<TileKey>& tiles = numbers.tiles();
  std::vector<uint64_t> point_count(tiles.size());
  for (const auto& [number, run] : runs) point_count[number] += run.end - run.begin;
  const std::vector<uint32_t> keep =
      NumbersToKeep(tiles, point_count, FewestPoints(point_count, max_tiles));
  PointsByTile sorted;
  LayOut(runs, keep, tiles.size(), &sorted);
  sorted.left_out = std::accumulate(point_count.begin(), point_count.end(), uint64_t{0});
  for (const uint32_t number : keep) {
    sorted.tiles.push_back(tiles[number]);
    sorted.point_count.push_back(static_cast<uint32_t>(point_count[number]));
    sorted.left_out -= point_count[number];
  }
  return sorted;
}

}  // namespace isthmus::composition
