#include "server/composition/tile_builder.h"

#include <algorithm>

namespace isthmus::composition {

TileBuilder::TileBuilder(const std::vector<TileKey>& wanted, const VoxelGrid& grid,
                         const TileLayout& layout)
    : grid_(grid), layout_(layout), buckets_(wanted.size()) {
  for (size_t i = 0; i < wanted.size(); ++i) bucket_of_tile_[wanted[i]] = i;
}

std::vector<TileBuilder::Entry>* TileBuilder::EntriesOf(Bucket* bucket, uint32_t robot) {
  for (size_t i = bucket->size(); i-- > 0;) {
    if ((*bucket)[i].robot == robot) return &(*bucket)[i].entries;
  }
  bucket->push_back({robot, {}});
  return &bucket->back().entries;
}

void TileBuilder::Add(const ThinnedSubmap& submap, uint32_t robot, uint32_t frame,
                      const Pose& T_map_submap) {
  // A submap lies on few tiles and neighbours in it mostly on one: remember where the last went.
  TileKey last_tile;
  std::vector<Entry>* last = nullptr;
  bool first = true;
  const auto visit = [&](const TileKey& tile, uint64_t voxel, const WeightedPoint& point) {
    if (first || tile != last_tile) {
      const auto it = bucket_of_tile_.find(tile);
      last = it == bucket_of_tile_.end() ? nullptr : EntriesOf(&buckets_[it->second], robot);
      last_tile = tile;
      first = false;
    }
    if (last) last->push_back({voxel, point});
  };
  ForEachPlacedPoint(submap, frame, T_map_submap, grid_, layout_, visit);
}

TilePtr TileBuilder::MakeTile(Bucket* bucket, const std::vector<RobotId>& robots,
                              VoxelThinner* thinner) {
  if (bucket->empty()) return nullptr;
  std::sort(bucket->begin(), bucket->end(), [&](const RobotPoints& l, const RobotPoints& r) {
    return robots[l.robot] < robots[r.robot];
  });
  auto tile = std::make_shared<Tile>();
  std::vector<WeightedPoint> thinned;
  for (const RobotPoints& of_robot : *bucket) {
    for (const Entry& entry : of_robot.entries) thinner->Add(entry.voxel, entry.point);
    thinned.clear();
    thinner->Take(&thinned);
    Tile::Part part{of_robot.robot, {}};
    part.points.reserve(thinned.size());
    for (const WeightedPoint& p : thinned) {
      part.points.push_back({p.x, p.y, p.z, p.intensity});
      tile->bounds.Extend(Eigen::Vector3d(p.x, p.y, p.z));
    }
    tile->point_count += part.points.size();
    tile->parts.push_back(std::move(part));
  }
  bucket->clear();
  bucket->shrink_to_fit();
  return tile;
}

std::vector<TilePtr> TileBuilder::Finish(const std::vector<RobotId>& robots,
                                         VoxelThinner* thinner) {
  std::vector<TilePtr> tiles;
  tiles.reserve(buckets_.size());
  for (Bucket& bucket : buckets_) tiles.push_back(MakeTile(&bucket, robots, thinner));
  return tiles;
}

}  // namespace isthmus::composition
