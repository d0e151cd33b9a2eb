#include "server/composition/tiles/tile_builder.h"

#include <array>
#include <cstddef>
#include <limits>
#include <utility>

#include "server/classes/limits.h"
#include "server/composition/limits.h"
#include "server/composition/placer.h"

namespace isthmus::composition {
namespace {

// Most of the time goes into waiting for the table's memory: so it is told early what will be
// asked.
// True if there are points that were left out.
bool AddPoints(const TileSource& source, const VoxelGrid& grid, VoxelThinner* thinner) {
  bool left_out = false;
  std::array<std::pair<uint64_t, WeightedPoint>, kPrefetchedPoints> batch;
  size_t waiting = 0;
  const auto add = [&] {
    for (size_t i = 0; i < waiting; ++i) {
      thinner->Add(batch[i].first, batch[i].second, source.stamp);
    }
    waiting = 0;
  };
  const Placer place(source.T_map_submap);
  for (const PointRun& run : source.runs) {
    for (uint32_t i = run.begin; i < run.end; ++i) {
      const WeightedPoint& point = (*source.points)[i];
      if (point.gone != source.gone) {
        left_out = true;
        continue;
      }
      const Eigen::Vector3f at = place(point);
      const auto voxel = grid.Find(at.x(), at.y(), at.z());
      if (!voxel) continue;
      const uint64_t key = PackVoxel(*voxel);
      thinner->Prefetch(key);
      WeightedPoint& placed = batch[waiting++].second;
      batch[waiting - 1].first = key;
      placed = {at.x(), at.y(), at.z(), point.intensity, point.weight};
      placed.label = point.label;
      placed.certainty = point.certainty;
      if (waiting == kPrefetchedPoints) add();
    }
  }
  add();
  return left_out;
}

PointClass LabelOf(const WeightedPoint& point) {
  const bool is_known = static_cast<float>(point.certainty) >= 255 * classes::kKnown;
  return is_known ? static_cast<PointClass>(point.label) : PointClass::kUnknown;
}

}  // namespace

void TileBuilder::Add(const TileSource& source) {
  if (has_part_ && robot_ != source.robot) EndPart();
  has_part_ = true;
  robot_ = source.robot;
  left_out_ = AddPoints(source, grid_, thinner_);
}

void TileBuilder::EndPart() {
  if (!std::exchange(has_part_, false)) return;
  TakePoints();
  if (points_.empty()) return;
  order_.Sort(voxels_);
  TilePart part{.robot = robot_, .begin = static_cast<uint32_t>(tile_.points.size())};
  for (uint32_t level = 0; level < kDetailLevels; ++level) {
    part.level_end[level] = part.begin + order_.level_size()[level];
  }
  tile_.record.parts.push_back(part);
  tile_.points.resize(part.end());
  TilePoint* out = tile_.points.data() + part.begin;
  for (const uint32_t index : order_.order()) *out++ = points_[index];
}

// From the thinner, with their voxels.
void TileBuilder::TakePoints() {
  points_.clear();
  voxels_.clear();
  points_.reserve(thinner_->size());
  voxels_.reserve(thinner_->size());
  constexpr float kFar = std::numeric_limits<float>::infinity();
  Eigen::Array3f min = Eigen::Array3f::Constant(kFar), max = -min;
  thinner_->TakeEach([&](const WeightedPoint& mean, const WeightedPoint& first, uint32_t stamp) {
    const Voxel voxel = grid_.Find(first.x, first.y, first.z).value_or(Voxel());
    // A mean that rounding takes out of its voxel would be a second point of another voxel.
    const auto inside = [this](float of_mean, float of_first, int32_t index) {
      return grid_.IsIn(of_mean, index) ? of_mean : of_first;
    };
    const Eigen::Array3f p(inside(mean.x, first.x, voxel.x), inside(mean.y, first.y, voxel.y),
                           inside(mean.z, first.z, voxel.z));
    min = min.min(p);
    max = max.max(p);
    voxels_.push_back(voxel);
    points_.push_back({p.x(), p.y(), p.z(), mean.intensity, LabelOf(mean), stamp});
  });
  if (points_.empty()) return;
  tile_.record.bounds.Extend(Eigen::Vector3d(min.cast<double>()));
  tile_.record.bounds.Extend(Eigen::Vector3d(max.cast<double>()));
}

TileContent TileBuilder::TakeContent() {
  EndPart();
  return std::exchange(tile_, {});
}

}  // namespace isthmus::composition
