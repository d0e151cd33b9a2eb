#include "server/composition/tile_builder.h"

#include <algorithm>
#include <array>
#include <utility>

namespace isthmus::composition {
namespace {

// A pose that is cheap to apply to many points, the same way every time.
class Placer {
 public:
  explicit Placer(const Pose& T_map_submap)
      : rotation_(T_map_submap.RotationMatrix().cast<float>()),
        translation_(T_map_submap.translation().cast<float>()) {}

  Eigen::Vector3f operator()(const WeightedPoint& p) const {
    return rotation_ * Eigen::Vector3f(p.x, p.y, p.z) + translation_;
  }

 private:
  Eigen::Matrix3f rotation_;
  Eigen::Vector3f translation_;
};

// Numbers tiles in the order in which they are met. A submap lies on few tiles, and neighbours in
// it mostly on one or on one of the last.
class TileNumbers {
 public:
  uint32_t Find(const TileKey& tile) {
    if (last_ < tiles_.size() && tiles_[last_] == tile) return last_;
    const auto it = std::find(tiles_.begin(), tiles_.end(), tile);
    last_ = static_cast<uint32_t>(it - tiles_.begin());
    if (it == tiles_.end()) tiles_.push_back(tile);
    return last_;
  }
  const std::vector<TileKey>& tiles() const { return tiles_; }

 private:
  std::vector<TileKey> tiles_;
  uint32_t last_ = 0;
};

}  // namespace

PointsByTile SortByTile(const std::vector<WeightedPoint>& points, uint32_t frame,
                        const Pose& T_map_submap, const VoxelGrid& grid, const TileLayout& layout) {
  const Placer place(T_map_submap);
  TileNumbers numbers;
  std::vector<std::pair<uint32_t, PointRun>> runs;  // With the tile's number.
  for (uint32_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector3f at = place(points[i]);
    const auto voxel = grid.Find(at.x(), at.y(), at.z());
    if (!voxel) continue;
    const uint32_t number = numbers.Find(layout.Find(frame, *voxel));
    if (runs.empty() || runs.back().first != number || runs.back().second.end != i) {
      runs.push_back({number, {i, i}});
    }
    runs.back().second.end = i + 1;
  }
  const std::vector<TileKey>& tiles = numbers.tiles();
  std::stable_sort(runs.begin(), runs.end(),
                   [&](const auto& l, const auto& r) { return tiles[l.first] < tiles[r.first]; });
  PointsByTile sorted;
  for (const auto& [number, run] : runs) {
    if (sorted.tiles.empty() || sorted.tiles.back() != tiles[number]) {
      sorted.tiles.push_back(tiles[number]);
      sorted.begin.push_back(static_cast<uint32_t>(sorted.runs.size()));
    }
    sorted.runs.push_back(run);
  }
  sorted.begin.push_back(static_cast<uint32_t>(sorted.runs.size()));
  return sorted;
}

namespace {

// Most of the time goes into waiting for the table's memory: so it is told early what will be
// asked.
void AddPoints(const TileSource& source, const VoxelGrid& grid, VoxelThinner* thinner) {
  constexpr size_t kBatch = 64;
  std::array<std::pair<uint64_t, WeightedPoint>, kBatch> batch;
  size_t waiting = 0;
  const auto add = [&] {
    for (size_t i = 0; i < waiting; ++i) thinner->Add(batch[i].first, batch[i].second);
    waiting = 0;
  };
  const Placer place(source.T_map_submap);
  for (const PointRun& run : source.runs) {
    for (uint32_t i = run.begin; i < run.end; ++i) {
      const WeightedPoint& point = (*source.points)[i];
      const Eigen::Vector3f at = place(point);
      const auto voxel = grid.Find(at.x(), at.y(), at.z());
      if (!voxel) continue;
      const uint64_t key = PackVoxel(*voxel);
      thinner->Prefetch(key);
      batch[waiting++] = {key, {at.x(), at.y(), at.z(), point.intensity, point.weight}};
      if (waiting == kBatch) add();
    }
  }
  add();
}

}  // namespace

void TileBuilder::Add(const TileSource& source) {
  if (has_part_ && robot_ != source.robot) EndPart();
  has_part_ = true;
  robot_ = source.robot;
  AddPoints(source, grid_, thinner_);
}

void TileBuilder::EndPart() {
  if (!std::exchange(has_part_, false)) return;
  scratch_.clear();
  thinner_->Take(&scratch_);
  if (scratch_.empty()) return;
  const auto begin = static_cast<uint32_t>(tile_.points.size());
  tile_.points.reserve(begin + scratch_.size());
  for (const WeightedPoint& p : scratch_) {
    tile_.points.push_back({p.x, p.y, p.z, p.intensity});
    tile_.bounds.Extend(Eigen::Vector3d(p.x, p.y, p.z));
  }
  tile_.parts.push_back({robot_, begin, static_cast<uint32_t>(tile_.points.size())});
}

TileContent TileBuilder::Take() {
  EndPart();
  return std::exchange(tile_, {});
}

}  // namespace isthmus::composition
