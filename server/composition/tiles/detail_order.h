// The order from coarse to fine of one robot's points on a tile, see TilePart.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "server/composition/limits.h"
#include "server/composition/voxel_thinner.h"

namespace isthmus::composition {

// Sorts voxels. Meant to be kept and used again: among tiles of like size it allocates nothing. Not
// thread safe.
class DetailOrder {
 public:
  // Sorts the voxels, all different: order()[k] is the index of the one that comes k-th. The order
  // depends on the set of voxels alone. Takes some ten nanoseconds for each.
  void Sort(const std::vector<Voxel>& voxels);
  const std::vector<uint32_t>& order() const { return order_; }
  // Number of voxels before the end of each level.
  const std::array<uint32_t, kDetailLevels>& level_size() const { return level_size_; }

 private:
  struct Entry {
    uint64_t code = 0;  // Place on the curve.
    uint32_t index = 0;
  };

  void FindCodes(const std::vector<Voxel>& voxels);
  void SortByCode();
  void OrderByLevel();

  std::vector<Entry> entries_, scratch_;
  uint64_t all_bits_ = 0;  // Bits that are set in any code.
  std::vector<uint8_t> level_;
  std::vector<uint32_t> order_;
  std::array<uint32_t, kDetailLevels> level_size_ = {};
};

}  // namespace isthmus::composition
