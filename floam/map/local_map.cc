#include "floam/map/local_map.h"

#include <algorithm>
#include <cmath>

#include "floam/map/limits.h"

namespace isthmus::floam {
namespace {

constexpr size_t kFirstTableSize = size_t{1} << 12;      // Layout: a power of two.
constexpr int64_t kAxisOffset = 1 << 20;                 // Layout: three axes of 21 bits in a key.
constexpr uint64_t kAxisMask = (uint64_t{1} << 21) - 1;  // Layout.

Eigen::Vector3d CentreOf(uint64_t key) {
  const auto axis = [key](int shift) {
    const double block = static_cast<double>(key >> shift & kAxisMask) - kAxisOffset;
    return kGridOriginM + (block + 0.5) * kBlockM;
  };
  return {axis(42), axis(21), axis(0)};
}

}  // namespace

LocalMap::LocalMap(ShapeKind kind, const LocalMapOptions& options)
    : kind_(kind), options_(options), table_(kFirstTableSize), reach_m_(options.radius_m) {}

LocalMap::Cell LocalMap::CellOf(const Eigen::Vector3d& p) {
  Cell cell;
  cell.key = 0;
  cell.voxel = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const double floor = std::floor((p[axis] - kGridOriginM) / kBlockM);
    cell.key = cell.key << 21 |
               (static_cast<uint64_t>(static_cast<int64_t>(floor) + kAxisOffset) & kAxisMask);
    cell.centre[axis] = kGridOriginM + (floor + 0.5) * kBlockM;
    cell.voxel = cell.voxel << 1 | (p[axis] >= cell.centre[axis] ? 1 : 0);
  }
  cell.offset = (p - cell.centre).cast<float>();
  return cell;
}

void LocalMap::Insert(const Eigen::Vector3d& p, float ring) {
  const Cell cell = CellOf(p);
  uint32_t index = FindBlock(cell.key);
  if (index == kNoBlock) {
    if (live_ >= kMostBlocksFactor * static_cast<size_t>(options_.max_blocks)) return;
    index = AddBlock(cell.key);
  }
  Block& block = BlockAt(index);
  VoxelSums& sums = block.sums[cell.voxel];
  sums.Add(cell.offset, ring);
  block.count += 1;
  block.scan = scan_;
  if (sums.count > options_.max_count) {
    block.count -= 0.5F * sums.count;
    sums.Scale(0.5F);
    block.fitted_count[cell.voxel] *= 0.5F;
    block.fitted_count[8] *= 0.5F;
  }
}

bool LocalMap::IsWithin(const Found& voxel, const Eigen::Vector3d& p) {
  for (int axis = 0; axis < 3; ++axis) {
    const double offset = p[axis] - voxel.origin[axis];
    const bool upper = (voxel.voxel >> (2 - axis) & 1) != 0;
    if (upper ? !(offset >= 0 && offset < kBlockM / 2) : !(offset < 0 && offset >= -kBlockM / 2))
      return false;
  }
  return true;
}

void LocalMap::Find(const Eigen::Vector3d& p, Found* found) {
  if (found->key != kNoKey && IsWithin(*found, p)) return;
  const Cell cell = CellOf(p);
  *found = {nullptr, cell.centre, cell.key, cell.voxel};
  const uint32_t index = FindBlock(cell.key);
  if (index == kNoBlock) return;
  Block& block = BlockAt(index);
  const Shape& fine = Fitted(block, cell.voxel);
  const Shape& nearest = fine.valid ? fine : Fitted(block, 8);
  if (nearest.valid) found->shape = &nearest;
}

const Shape& LocalMap::Fitted(Block& block, int level) {
  const float count = level < 8 ? block.sums[level].count : block.count;
  if (count > kRefitGrowth * block.fitted_count[level]) {
    block.fitted_count[level] = count;
    if (level < 8) {
      block.shapes[level] = FitShape(block.sums[level], kind_);
    } else {
      VoxelSums all;
      for (const VoxelSums& sums : block.sums) all.Add(sums);
      block.shapes[level] = FitShape(all, kind_);
    }
  }
  return block.shapes[level];
}

void LocalMap::Evict(const Eigen::Vector3d& robot) {
  // Shrinks the reach while there are too many blocks, and lets it recover once there are fewer.
  if (live_ > static_cast<size_t>(options_.max_blocks)) {
    reach_m_ *= 0.98;
  } else if (live_ < static_cast<size_t>(options_.max_blocks) * 9 / 10) {
    reach_m_ = std::min(options_.radius_m, reach_m_ * 1.02);
  }
  ++scan_;
  const double lasting2 = options_.lasting_radius_m * options_.lasting_radius_m;
  const uint32_t looks = std::min<uint32_t>(allocated_, kEvictedPerScan);
  for (uint32_t k = 0; k < looks; ++k) {
    cursor_ = cursor_ + 1 < allocated_ ? cursor_ + 1 : 0;
    const Block& block = BlockAt(cursor_);
    if (block.key == kNoKey) continue;
    const double distance2 = (CentreOf(block.key) - robot).squaredNorm();
    const bool dated = scan_ - block.scan > options_.lasting_scans && distance2 > lasting2;
    if (distance2 > reach_m_ * reach_m_ || dated) RemoveBlock(cursor_);
  }
}

void LocalMap::Clear() {
  table_.assign(kFirstTableSize, Slot());
  chunks_.clear();
  free_.clear();
  allocated_ = 0;
  live_ = 0;
  cursor_ = 0;
}

uint32_t LocalMap::FindBlock(uint64_t key) const {
  const size_t mask = table_.size() - 1;
  size_t slot = hash_(key) & mask;
  while (table_[slot].block != kNoBlock && table_[slot].key != key) slot = (slot + 1) & mask;
  return table_[slot].block;
}

uint32_t LocalMap::AddBlock(uint64_t key) {
  if (2 * (live_ + 1) > table_.size()) GrowTable();
  uint32_t index;
  if (free_.empty()) {
    index = allocated_++;
    if (index % kChunk == 0) chunks_.push_back(std::make_unique<Block[]>(kChunk));
  } else {
    index = free_.back();
    free_.pop_back();
    BlockAt(index) = Block();
  }
  BlockAt(index).key = key;
  ++live_;
  Place({key, index});
  return index;
}

void LocalMap::Place(const Slot& entry) {
  const size_t mask = table_.size() - 1;
  size_t slot = hash_(entry.key) & mask;
  while (table_[slot].block != kNoBlock) slot = (slot + 1) & mask;
  table_[slot] = entry;
}

void LocalMap::RemoveBlock(uint32_t index) {
  const size_t mask = table_.size() - 1;
  size_t hole = hash_(BlockAt(index).key) & mask;
  while (table_[hole].block != index) hole = (hole + 1) & mask;
  // Closes the gap in the probe sequence: moves back what could not be found past it.
  for (size_t slot = (hole + 1) & mask; table_[slot].block != kNoBlock; slot = (slot + 1) & mask) {
    const size_t home = hash_(table_[slot].key) & mask;
    if (((slot - home) & mask) >= ((slot - hole) & mask)) {
      table_[hole] = table_[slot];
      hole = slot;
    }
  }
  table_[hole] = Slot();
  BlockAt(index).key = kNoKey;
  free_.push_back(index);
  --live_;
}

void LocalMap::GrowTable() {
  std::vector<Slot> old(table_.size() * 2);
  old.swap(table_);
  for (const Slot& entry : old) {
    if (entry.block != kNoBlock) Place(entry);
  }
}

}  // namespace isthmus::floam
