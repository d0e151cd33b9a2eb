// The local map's part of a saved state: column by column, which compresses best.
#include <algorithm>
#include <cmath>

#include "core/state_codec.h"
#include "floam/map/limits.h"
#include "floam/map/local_map.h"

namespace isthmus::floam {
namespace {

constexpr size_t kSums = 11, kShape = 8;  // Format: numbers of a voxel's sums, and of a shape.
constexpr int kLevels = 9;                // Format: eight voxels, and the block.

std::array<float, kSums> Numbers(const VoxelSums& s) {
  return {s.count, s.first.x(), s.first.y(), s.first.z(), s.xx,  s.xy,
          s.xz,    s.yy,        s.yz,        s.zz,        s.ring};
}

std::array<float, kShape> Numbers(const Shape& s) {
  return {s.mean.x(),      s.mean.y(),      s.mean.z(), s.direction.x(),
          s.direction.y(), s.direction.z(), s.variance, s.tilt_variance};
}

VoxelSums MakeSums(const std::array<float, kSums>& n) {
  return {n[0], {n[1], n[2], n[3]}, n[4], n[5], n[6], n[7], n[8], n[9], n[10]};
}

Shape MakeShape(const std::array<float, kShape>& n) {
  return {{n[0], n[1], n[2]}, {n[3], n[4], n[5]}, n[6], n[7], true};
}

// Records of n numbers each, one column per number.
template <size_t n>
class Table {
 public:
  void Add(const std::array<float, n>& record) {
    for (size_t k = 0; k < n; ++k) columns_[k].push_back(record[k]);
  }
  // The next record; zeros beyond the last.
  std::array<float, n> Next() {
    std::array<float, n> record{};
    if (next_ < columns_[0].size()) {
      for (size_t k = 0; k < n; ++k) record[k] = columns_[k][next_];
    }
    ++next_;
    return record;
  }
  // All records were read, no more than there are, and all columns are as long and finite.
  bool IsDone() const { return next_ == columns_[0].size(); }
  bool IsSound() const {
    return std::all_of(columns_.begin(), columns_.end(), [&](const std::vector<float>& column) {
      return column.size() == columns_[0].size() &&
             std::all_of(column.begin(), column.end(), [](float v) { return std::isfinite(v); });
    });
  }

  template <typename Self, typename Io>
  static void Fields(Self& self, Io& io) {
    io(self.columns_);
  }

 private:
  std::array<std::vector<float>, n> columns_;
  size_t next_ = 0;
};

}  // namespace

struct LocalMap::Columns {
  std::vector<uint64_t> keys;  // One for every index; the rest only for blocks in use.
  std::vector<uint32_t> scans;
  std::vector<uint8_t> occupied;        // Bit by bit: voxels with points.
  std::vector<uint16_t> fitted, valid;  // Shapes that were looked for, and found.
  mutable Table<1> counts, fit_counts;  // Counts of blocks: now, and at the time of fitting.
  mutable Table<kSums> sums;
  mutable Table<kShape> shapes;

  template <typename Self, typename Io>
  static void Fields(Self& self, Io& io) {
    io(self.keys, self.scans, self.occupied, self.fitted, self.valid, self.counts, self.fit_counts,
       self.sums, self.shapes);
  }
  bool IsSound(size_t live) const {
    return scans.size() == live && occupied.size() == live && fitted.size() == live &&
           valid.size() == live && counts.IsSound() && fit_counts.IsSound() && sums.IsSound() &&
           shapes.IsSound();
  }
};

void LocalMap::Fields(const LocalMap& self, StateWriter& io) {
  Columns columns;
  for (uint32_t index = 0; index < self.allocated_; ++index) {
    const Block& block = self.BlockAt(index);
    columns.keys.push_back(block.key);
    if (block.key == kNoKey) continue;
    uint8_t occupied = 0;
    for (int voxel = 0; voxel < 8; ++voxel) {
      if (block.sums[voxel].count == 0) continue;
      occupied = static_cast<uint8_t>(occupied | 1 << voxel);
      columns.sums.Add(Numbers(block.sums[voxel]));
    }
    uint16_t fitted = 0, valid = 0;
    for (int level = 0; level < kLevels; ++level) {
      if (block.fitted_count[level] == 0) continue;
      fitted = static_cast<uint16_t>(fitted | 1 << level);
      columns.fit_counts.Add({block.fitted_count[level]});
      if (!block.shapes[level].valid) continue;
      valid = static_cast<uint16_t>(valid | 1 << level);
      columns.shapes.Add(Numbers(block.shapes[level]));
    }
    columns.scans.push_back(block.scan);
    columns.counts.Add({block.count});
    columns.occupied.push_back(occupied);
    columns.fitted.push_back(fitted);
    columns.valid.push_back(valid);
  }
  io(columns, self.free_, self.cursor_, self.scan_, self.reach_m_);
}

bool LocalMap::AddRestored(uint32_t index, uint64_t key) {
  if (key >> 63 != 0 || FindBlock(key) != kNoBlock) return false;
  if (2 * (live_ + 1) > table_.size()) GrowTable();
  BlockAt(index).key = key;
  ++live_;
  Place({key, index});
  return true;
}

// The blocks of an empty map.
void LocalMap::Unpack(const Columns& columns, StateReader& io) {
  allocated_ = static_cast<uint32_t>(columns.keys.size());
  for (uint32_t begin = 0; begin < allocated_; begin += kChunk) {
    chunks_.push_back(std::make_unique<Block[]>(kChunk));
  }
  size_t next = 0;
  for (uint32_t index = 0; index < allocated_ && io.ok(); ++index) {
    if (columns.keys[index] == kNoKey) continue;
    io.Expect(AddRestored(index, columns.keys[index]));
    Block& block = BlockAt(index);
    block.scan = columns.scans[next];
    block.count = columns.counts.Next()[0];
    for (int voxel = 0; voxel < 8; ++voxel) {
      if (columns.occupied[next] >> voxel & 1) block.sums[voxel] = MakeSums(columns.sums.Next());
    }
    for (int level = 0; level < kLevels; ++level) {
      if (columns.fitted[next] >> level & 1) {
        block.fitted_count[level] = columns.fit_counts.Next()[0];
      }
      if (columns.valid[next] >> level & 1) block.shapes[level] = MakeShape(columns.shapes.Next());
    }
    ++next;
  }
  io.Expect(columns.counts.IsDone() && columns.fit_counts.IsDone() && columns.sums.IsDone() &&
            columns.shapes.IsDone());
}

void LocalMap::Fields(LocalMap& self, StateReader& io) {
  Columns columns;
  self.Clear();
  io(columns, self.free_, self.cursor_, self.scan_, self.reach_m_);
  const size_t allocated = columns.keys.size();
  const auto unused = std::count(columns.keys.begin(), columns.keys.end(), kNoKey);
  const size_t live = allocated - static_cast<size_t>(unused);
  io.Expect(allocated <= kMaxAllocatedFactor * static_cast<size_t>(self.options_.max_blocks) &&
            columns.IsSound(live) && self.free_.size() == allocated - live &&
            (self.cursor_ == 0 || self.cursor_ < allocated) && self.reach_m_ > 0 &&
            self.reach_m_ <= self.options_.radius_m);
  std::vector<bool> is_free(io.ok() ? allocated : 0);
  for (size_t k = 0; k < self.free_.size() && io.ok(); ++k) {
    const uint32_t index = self.free_[k];
    const bool is_new = index < allocated && columns.keys[index] == kNoKey && !is_free[index];
    io.Expect(is_new);
    if (is_new) is_free[index] = true;
  }
  if (io.ok()) self.Unpack(columns, io);
  if (!io.ok()) self.Clear();
}

}  // namespace isthmus::floam
