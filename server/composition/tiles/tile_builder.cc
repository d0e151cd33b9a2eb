#include "server/composition/tiles/tile_builder.h"

#include <array>
#include <cstddef>
#include <utility>

#include "server/composition/limits.h"
#include "server/composition/placer.h"

namespace isthmus::composition {
namespace {

// Most of the time goes into waiting for the table's memory: so it is told early what will be
// asked.
void AddPoints(const TileSource& source, const VoxelGrid& grid, VoxelThinner* thinner) {
  std::array<std::pair<uint64_t, WeightedPoint>, kPrefetchedPoints> batch;
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
      if (waiting == kPrefetchedPoints) add();
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
  thinner_->TakePoints(&scratch_);
  if (scratch_.empty()) return;
  const auto begin = static_cast<uint32_t>(tile_.points.size());
  tile_.points.reserve(begin + scratch_.size());
  for (const WeightedPoint& p : scratch_) {
    tile_.points.push_back({p.x, p.y, p.z, p.intensity});
    tile_.bounds.Extend(Eigen::Vector3d(p.x, p.y, p.z));
  }
  tile_.parts.push_back({robot_, begin, static_cast<uint32_t>(tile_.points.size())});
}

TileContent TileBuilder::TakeContent() {
  EndPart();
  return std::exchange(tile_, {});
}

}  // namespace isthmus::composition
