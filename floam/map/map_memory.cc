#include "floam/map/map_memory.h"

#include <algorithm>
#include <cmath>

namespace isthmus::floam {
namespace {

constexpr int kVoxelsPerTile = 2 * MapMemory::kCells;
// Heights are counted from here, so that they are never negative.
constexpr int64_t kHeightOffset = int64_t{1} << 21;
constexpr int64_t kHeightMax = (int64_t{1} << 22) - 1;
// A cell holds a wall if this many levels of voxels are seen within so many that follow each other:
// a floor with its noise is in two.
constexpr int kWallLevels = 3;
constexpr uint32_t kWallWindow = 5;
// The number of voxels of a cell that a submap must see to have looked at it.
constexpr int kLookedAtVoxels = 2;
// The share that is forgotten when there is too much.
constexpr double kForgottenShare = 0.25;

uint32_t HeightOf(uint32_t key) { return key >> 2 & 0x3fffff; }
uint32_t CellOf(uint32_t key) { return key >> 24; }

MapMemory::TileIndex SquareAt(double x, double y, double size) {
  return {static_cast<int>(std::floor(x / size)), static_cast<int>(std::floor(y / size))};
}

}  // namespace

MapMemory::MapMemory(const MapMemoryOptions& options)
    : options_(options), thinner_(static_cast<float>(kVoxelM)) {}

MapMemory::TileIndex MapMemory::TileAt(double x, double y) { return SquareAt(x, y, kTileM); }

uint64_t MapMemory::KeyOf(TileIndex index) {
  return static_cast<uint64_t>(static_cast<uint32_t>(index.x)) << 32 |
         static_cast<uint32_t>(index.y);
}

void MapMemory::Add(const Submap& submap, const Pose& T_map_submap) {
  for (const Keyframe& keyframe : submap.keyframes) {
    const Eigen::Vector3d at = (T_map_submap * keyframe.T_submap_sensor).translation();
    sensors_[KeyOf(SquareAt(at.x(), at.y(), options_.keyframe_spacing_m))] = at;
  }
  Gather(submap, T_map_submap);
  std::sort(incoming_.begin(), incoming_.end(), [](const Incoming& a, const Incoming& b) {
    return a.tile != b.tile ? a.tile < b.tile : a.voxel.key < b.voxel.key;
  });
  const Incoming* const end = incoming_.data() + incoming_.size();
  for (const Incoming* begin = incoming_.data(); begin != end;) {
    const Incoming* next = begin;
    while (next != end && next->tile == begin->tile) ++next;
    Merge(begin, next, &tiles_[begin->tile]);
    begin = next;
  }
  if (voxels_ > options_.max_voxels) ForgetOldest();
}

// One point per voxel of the submap, with the tile it falls into.
void MapMemory::Gather(const Submap& submap, const Pose& T_map_submap) {
  incoming_.clear();
  thinner_.Clear();
  const Eigen::Matrix3d R = T_map_submap.RotationMatrix();
  const Eigen::Vector3d& t = T_map_submap.translation();
  // The thinner takes coordinates near zero; whole voxels away from it voxels stay the same.
  const Eigen::Vector3d base = (t / kVoxelM).array().floor() * kVoxelM;
  const auto max_range2 = static_cast<float>(options_.max_range_m * options_.max_range_m);
  for (const SubmapPoint& point : submap.points) {
    const Eigen::Vector3d sensor = submap.keyframes[point.keyframe].T_submap_sensor.translation();
    if (!((point.Position() - sensor.cast<float>()).squaredNorm() <= max_range2)) continue;
    const Eigen::Vector3d p = R * point.Position().cast<double>() + t;
    const Eigen::Vector3f near = (p - base).cast<float>();
    if (!thinner_.Insert(near.x(), near.y(), near.z())) continue;
    const TileIndex tile = TileAt(p.x(), p.y());
    const Eigen::Vector3d local(p.x() - tile.x * kTileM, p.y() - tile.y * kTileM, p.z());
    const Eigen::Vector3d scaled = local / kVoxelM;
    const int x = std::clamp(static_cast<int>(scaled.x()), 0, kVoxelsPerTile - 1);
    const int y = std::clamp(static_cast<int>(scaled.y()), 0, kVoxelsPerTile - 1);
    const double level = std::floor(scaled.z());
    const int64_t z =
        std::clamp<int64_t>(static_cast<int64_t>(level) + kHeightOffset, 0, kHeightMax);
    Voxel voxel;
    voxel.key = static_cast<uint32_t>(int64_t{y / 2 * kCells + x / 2} << 24 | z << 2 |
                                      (y % 2) << 1 | (x % 2));
    voxel.submap = submap.id.index;
    const Eigen::Vector3d offset = 256 * (scaled - Eigen::Vector3d(x, y, level));
    for (int axis = 0; axis < 3; ++axis) {
      voxel.offset[axis] = static_cast<uint8_t>(std::clamp(offset[axis], 0.0, 255.0));
    }
    incoming_.push_back({KeyOf(tile), voxel});
  }
}

void MapMemory::Merge(const Incoming* begin, const Incoming* end, Tile* tile) {
  merged_.clear();
  const std::vector<Voxel>& old = tile->voxels;
  size_t k = 0;
  for (const Incoming* in = begin; in != end; ++in) {
    if (!merged_.empty() && merged_.back().key == in->voxel.key) continue;
    while (k < old.size() && old[k].key < in->voxel.key) merged_.push_back(old[k++]);
    if (k < old.size() && old[k].key == in->voxel.key) ++k;  // The newer one replaces it.
    merged_.push_back(in->voxel);
  }
  merged_.insert(merged_.end(), old.begin() + static_cast<std::ptrdiff_t>(k), old.end());
  DropStale(begin->voxel.submap);
  voxels_ += merged_.size() - old.size();
  tile->voxels = merged_;  // Exactly as much memory as needed.
  Classify(tile);
}

// In the cells of `merged_` that `submap` has seen.
void MapMemory::DropStale(uint32_t submap) {
  if (submap <= options_.fresh_submaps) return;
  const uint32_t oldest = submap - options_.fresh_submaps;
  auto kept = merged_.begin();
  for (auto begin = merged_.begin(); begin != merged_.end();) {
    const auto end = std::find_if(begin, merged_.end(), [&](const Voxel& voxel) {
      return CellOf(voxel.key) != CellOf(begin->key);
    });
    const auto seen =
        std::count_if(begin, end, [&](const Voxel& voxel) { return voxel.submap == submap; });
    const bool stale_goes = seen >= kLookedAtVoxels;
    kept = std::copy_if(begin, end, kept,
                        [&](const Voxel& voxel) { return !stale_goes || voxel.submap >= oldest; });
    begin = end;
  }
  merged_.erase(kept, merged_.end());
}

void MapMemory::Classify(Tile* tile) {
  tile->cells.fill(Cell::kUnknown);
  std::array<uint32_t, kWallLevels> levels{};  // The last heights of the cell, oldest first.
  int seen = 0;
  uint32_t cell = ~uint32_t{0};
  for (const Voxel& voxel : tile->voxels) {
    const uint32_t height = HeightOf(voxel.key);
    if (CellOf(voxel.key) != cell) {
      cell = CellOf(voxel.key);
      tile->cells[cell] = Cell::kFlat;
      seen = 0;
    } else if (height == levels.back()) {
      continue;
    }
    std::rotate(levels.begin(), levels.begin() + 1, levels.end());
    levels.back() = height;
    ++seen;
    if (seen >= kWallLevels && height - levels.front() < kWallWindow) {
      tile->cells[cell] = Cell::kWall;
    }
  }
}

void MapMemory::ForgetOldest() {
  std::vector<uint32_t> ages;
  ages.reserve(voxels_);
  for (const auto& [key, tile] : tiles_) {
    for (const Voxel& voxel : tile.voxels) ages.push_back(voxel.submap);
  }
  const auto cut = ages.begin() +
                   static_cast<std::ptrdiff_t>(kForgottenShare * static_cast<double>(ages.size()));
  std::nth_element(ages.begin(), cut, ages.end());
  const uint32_t oldest_kept = *cut + 1;
  voxels_ = 0;
  for (auto it = tiles_.begin(); it != tiles_.end();) {
    Tile& tile = it->second;
    std::erase_if(tile.voxels, [&](const Voxel& voxel) { return voxel.submap < oldest_kept; });
    tile.voxels.shrink_to_fit();
    voxels_ += tile.voxels.size();
    Classify(&tile);
    it = tile.voxels.empty() ? tiles_.erase(it) : std::next(it);
  }
}

size_t MapMemory::MemoryBytes() const {
  return voxels_ * sizeof(Voxel) + tiles_.size() * (sizeof(Tile) + 4 * sizeof(void*)) +
         sensors_.size() * (sizeof(Eigen::Vector3d) + 5 * sizeof(void*));
}

std::vector<Eigen::Vector3d> MapMemory::SensorPositions() const {
  std::vector<Eigen::Vector3d> positions;
  positions.reserve(sensors_.size());
  for (const auto& [key, position] : sensors_) positions.push_back(position);
  return positions;
}

const std::array<MapMemory::Cell, MapMemory::kCells * MapMemory::kCells>* MapMemory::Cells(
    TileIndex index) const {
  const auto it = tiles_.find(KeyOf(index));
  return it == tiles_.end() ? nullptr : &it->second.cells;
}

void MapMemory::AppendPoints(TileIndex index, std::vector<SeenPoint>* out) const {
  const auto it = tiles_.find(KeyOf(index));
  if (it == tiles_.end()) return;
  const double voxel_m = kVoxelM;
  for (const Voxel& voxel : it->second.voxels) {
    const uint32_t cell = CellOf(voxel.key);
    const auto x = 2 * (cell % kCells) + (voxel.key & 1);
    const auto y = 2 * (cell / kCells) + (voxel.key >> 1 & 1);
    const auto z = static_cast<int64_t>(HeightOf(voxel.key)) - kHeightOffset;
    const auto at = [&](double low, int axis) {
      return static_cast<float>((low + (voxel.offset[axis] + 0.5) / 256) * voxel_m);
    };
    out->push_back(
        {{static_cast<float>(index.x * kTileM) + at(x, 0),
          static_cast<float>(index.y * kTileM) + at(y, 1), at(static_cast<double>(z), 2)},
         it->second.cells[cell] == Cell::kWall});
  }
}

}  // namespace isthmus::floam
