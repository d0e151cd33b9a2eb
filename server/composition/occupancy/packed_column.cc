#include "server/composition/occupancy/packed_column.h"

#include <absl/container/flat_hash_map.h>

namespace isthmus::composition {
namespace {

class Packer {
 public:
  Packer(const VoxelColumn& column, std::vector<float>* levels, std::vector<uint8_t>* bytes)
      : column_(column), levels_(levels), bytes_(bytes) {}

  // Appends a cube of the column; false, and nothing, where nothing of it was seen.
  bool AddCube(int32_t z) {
    const size_t begin = bytes_->size();
    bytes_->push_back(0);
    const Branch branch = Add(kColumnBits, {0, 0, z << kColumnBits});
    if (branch == Branch::kUnknown) {
      bytes_->resize(begin);
      return false;
    }
    (*bytes_)[begin] = static_cast<uint8_t>(branch);
    if (branch == Branch::kLeaf) AddLevel(value_);
    return true;
  }

 private:
  // Appends an inner node with all below it. Of a leaf only value_ is set.
  Branch Add(int bits, const VoxelIndex& lowest) {
    if (bits == kBlockBits) {
      block_ = column_.BlockAt(lowest.x(), lowest.y(), lowest.z() >> kBlockBits);
      if (block_ == nullptr) return Branch::kUnknown;
    }
    if (bits == 0) {
      const VoxelCell& cell = (*block_)[CellInBlock(lowest.x(), lowest.y(), lowest.z())];
      value_ = cell.log_odds;
      return cell.scan == 0 ? Branch::kUnknown : Branch::kLeaf;
    }
    const size_t begin = bytes_->size();
    bytes_->resize(begin + 2);
    uint32_t children = 0;
    float first = 0;
    bool alike = true;
    for (int child = 0; child < kChildren; ++child) {
      const VoxelIndex corner(child & 1, child >> 1 & 1, child >> 2);
      const Branch branch = Add(bits - 1, lowest + corner * (1 << (bits - 1)));
      children |= static_cast<uint32_t>(branch) << 2 * child;
      if (branch == Branch::kLeaf) AddLevel(value_);
      if (child == 0) first = value_;
      alike = alike && branch == Branch::kLeaf && value_ == first;
    }
    value_ = first;
    if (alike || children == 0) {
      bytes_->resize(begin);
      return alike ? Branch::kLeaf : Branch::kUnknown;
    }
    (*bytes_)[begin] = static_cast<uint8_t>(children);
    (*bytes_)[begin + 1] = static_cast<uint8_t>(children >> 8);
    return Branch::kInner;
  }

  void AddLevel(float value) {
    const auto [it, is_new] = numbers_.try_emplace(value, static_cast<uint32_t>(levels_->size()));
    if (is_new) levels_->push_back(value);
    uint32_t level = it->second;
    for (; level >= 0x80; level >>= 7) bytes_->push_back(static_cast<uint8_t>(level | 0x80));
    bytes_->push_back(static_cast<uint8_t>(level));
  }

  const VoxelColumn& column_;
  std::vector<float>* const levels_;
  std::vector<uint8_t>* const bytes_;
  absl::flat_hash_map<float, uint32_t> numbers_;  // Index into levels_, by log-odds.
  const VoxelBlock* block_ = nullptr;
  float value_ = 0;
};

void Fill(int bits, const VoxelIndex& lowest, const VoxelCell& cell, VoxelColumn* column) {
  const int32_t edge = 1 << bits;
  for (int32_t z = 0; z < edge; ++z) {
    for (int32_t y = 0; y < edge; ++y) {
      for (int32_t x = 0; x < edge; ++x) column->At(lowest + VoxelIndex(x, y, z)) = cell;
    }
  }
}

void UnpackBranch(Branch branch, int bits, const VoxelIndex& lowest,
                  const std::vector<float>& levels, uint32_t scan, const uint8_t** at,
                  VoxelColumn* column) {
  if (branch == Branch::kUnknown) return;
  if (branch == Branch::kLeaf) {
    Fill(bits, lowest, {levels[TakeLevel(at)], scan}, column);
    return;
  }
  const uint32_t children = TakeChildren(at);
  for (int child = 0; child < kChildren; ++child) {
    const VoxelIndex corner(child & 1, child >> 1 & 1, child >> 2);
    UnpackBranch(ChildOf(children, child), bits - 1, lowest + corner * (1 << (bits - 1)), levels,
                 scan, at, column);
  }
}

}  // namespace

PackedColumn::PackedColumn(const VoxelColumn& column) {
  Packer packer(column, &levels_, &bytes_);
  constexpr int kShift = kColumnBits - kBlockBits;
  for (int32_t z = column.bottom() >> kShift; z << kShift < column.top(); ++z) {
    const Cube cube{z, static_cast<uint32_t>(bytes_.size())};
    if (packer.AddCube(z)) cubes_.push_back(cube);
  }
  levels_.shrink_to_fit();
  bytes_.shrink_to_fit();
  cubes_.shrink_to_fit();
}

void PackedColumn::Unpack(uint32_t scan, VoxelColumn* column) const {
  for (const Cube& cube : cubes_) Unpack(cube, scan, column);
}

void PackedColumn::Unpack(const Cube& cube, uint32_t scan, VoxelColumn* column) const {
  const uint8_t* at = BytesOf(cube);
  const auto branch = static_cast<Branch>(*at++);
  UnpackBranch(branch, kColumnBits, {0, 0, cube.z << kColumnBits}, levels_, scan, &at, column);
}

}  // namespace isthmus::composition
