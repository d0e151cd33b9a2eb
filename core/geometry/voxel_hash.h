// A hash of voxel numbers that differs from process to process.
//
// Points come over the network, and with a hash that is known, points can be chosen whose voxels
// all fall into the same slot of a table: each would be looked for past all before it. Nobody
// outside knows this one, so any voxels chosen beforehand are spread as if they were drawn at
// random. The output of a table must therefore not be in its own order, or results would differ
// from run to run.
#pragma once

#include <cstdint>

namespace isthmus {

// Value type.
class VoxelHash {
 public:
  // The process's own; the same for all who ask.
  VoxelHash();
  // One that is known, `multiplier` odd.
  VoxelHash(uint64_t mask, uint64_t multiplier) : mask_(mask), multiplier_(multiplier) {}

  // All bits depend on all of the voxel's: both halves of a product that is not cut off, as in
  // https://github.com/wangyi-fudan/wyhash.
  uint64_t operator()(uint64_t voxel) const {
    const Product product = static_cast<Product>(voxel ^ mask_) * multiplier_;
    return static_cast<uint64_t>(product) ^ static_cast<uint64_t>(product >> 64);
  }

 private:
  __extension__ using Product = unsigned __int128;

  uint64_t mask_, multiplier_;
};

}  // namespace isthmus
