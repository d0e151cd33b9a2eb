#include "server/composition/voxel_thinner.h"

#include <algorithm>

#include "server/composition/limits.h"

namespace isthmus::composition {
namespace {

float VotesOf(const WeightedPoint& point) {
  return static_cast<float>(point.weight) * static_cast<float>(point.certainty);
}

}  // namespace

VoxelThinner::VoxelThinner() : slots_(size_t{1} << kFirstTableBits), shift_(64 - kFirstTableBits) {}

size_t VoxelThinner::FindSlot(uint64_t key) const {
  const size_t mask = slots_.size() - 1;
  size_t i = FirstSlot(key);
  while (slots_[i].key != key && slots_[i].key != kNoVoxel) i = (i + 1) & mask;
  return i;
}

void VoxelThinner::Grow() {
  std::vector<Slot> old(slots_.size() * 2);
  old.swap(slots_);
  --shift_;
  for (const Slot& slot : old) {
    if (slot.key != kNoVoxel) slots_[FindSlot(slot.key)] = slot;
  }
}

// Clearing costs what the table is large: one cloud of millions must not make it slow for all the
// small ones after it, nor keep its memory.
void VoxelThinner::Shrink() {
  slots_ = std::vector<Slot>(slots_.size() / 2);
  ++shift_;
  cells_.shrink_to_fit();
}

void VoxelThinner::Add(uint64_t voxel, const WeightedPoint& point, uint32_t stamp) {
  size_t i = FindSlot(voxel);
  if (slots_[i].key == kNoVoxel) {
    if (cells_.size() * 2 >= slots_.size()) {
      Grow();
      i = FindSlot(voxel);
    }
    slots_[i] = {voxel, static_cast<uint32_t>(cells_.size())};
    cells_.push_back({.first = point, .votes = VotesOf(point), .stamp = stamp});
    return;
  }
  Cell& cell = cells_[slots_[i].cell];
  const float weight = static_cast<float>(point.weight);
  cell.dx += weight * (point.x - cell.first.x);
  cell.dy += weight * (point.y - cell.first.y);
  cell.dz += weight * (point.z - cell.first.z);
  cell.di += weight * (point.intensity - cell.first.intensity);
  cell.first.weight += point.weight;
  cell.stamp = std::max(cell.stamp, stamp);
  cell.votes += cell.first.label == point.label ? VotesOf(point) : -VotesOf(point);
  if (cell.votes < 0) {
    cell.votes = -cell.votes;
    cell.first.label = point.label;
  }
}

void VoxelThinner::TakePoints(std::vector<WeightedPoint>* out) {
  out->reserve(out->size() + cells_.size());
  for (const Cell& cell : cells_) out->push_back(Mean(cell));
  Forget();
}

void VoxelThinner::Forget() {
  const bool is_roomy =
      slots_.size() > size_t{1} << kFirstTableBits && cells_.size() * kRoomySlots < slots_.size();
  cells_.clear();
  roomy_in_a_row_ = is_roomy ? roomy_in_a_row_ + 1 : 0;
  if (roomy_in_a_row_ > kRoomyClouds) {
    Shrink();
  } else {
    slots_.assign(slots_.size(), Slot());
  }
}

}  // namespace isthmus::composition
