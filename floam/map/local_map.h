// The part of the world around the robot that scans are matched to.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "core/geometry/voxel_hash.h"
#include "floam/map/voxel_statistics.h"

namespace isthmus {
class StateReader;  // core/state_codec.h
class StateWriter;
}  // namespace isthmus

namespace isthmus::floam {

struct LocalMapOptions {
  double radius_m = 80;  // Blocks farther than this from the robot are forgotten ...
  // ... and those farther than this that nothing was put into for so many scans of the map (one per
  // 0.1 m of travel, or more): what drift has since moved, should the robot come back, had better
  // be mapped anew than be matched to.
  double lasting_radius_m = 50;
  uint32_t lasting_scans = 5000;
  int max_blocks = 200'000;  // ... and sooner where there are more (about 0.6 kB each).
  float max_count = 400;     // Points a voxel remembers; older ones fade.
};

// Statistics of points on two levels, voxels of 0.5 m in blocks of 1 m, in a hash table that only
// ever changes block by block: nothing is rebuilt. Coordinates are metres in the odom frame, within
// 1000 km of its origin. Not thread safe.
class LocalMap {
 public:
  static constexpr uint64_t kNoKey = ~uint64_t{0};

  LocalMap(ShapeKind kind, const LocalMapOptions& options);

  // `ring`: that it is of; kSeveral if that is not known. Left out where it would take a block more
  // than twice LocalMapOptions::max_blocks.
  void Insert(const Eigen::Vector3d& p, float ring = VoxelSums::kSeveral);

  // The shape near a point, and where it was found. Good until the next Insert, Evict or Clear.
  struct Found {
    const Shape* shape = nullptr;                      // Null if there is none.
    Eigen::Vector3d origin = Eigen::Vector3d::Zero();  // The origin of Shape::mean.
    uint64_t key = kNoKey;                             // The voxel's.
    int voxel = 0;
  };
  // Sets `*found` to the shape of the voxel at p or, if that has none, of its block. Costs next to
  // nothing if `*found` is from an earlier call for a point of the same voxel.
  void Find(const Eigen::Vector3d& p, Found* found);

  // To be called after every scan that was inserted. Looks at a part of the blocks, a few hundred
  // per call, and forgets those out of reach or out of date.
  void Evict(const Eigen::Vector3d& robot);

  void Clear();
  size_t block_count() const { return live_; }

  // For state_codec.h: local_map_state.cc. Blocks keep their indices, on which it rests when they
  // are evicted; shapes are kept as they were fitted, which may have been with fewer points.
  static void Fields(const LocalMap& self, StateWriter& io);
  static void Fields(LocalMap& self, StateReader& io);

 private:
  static constexpr uint32_t kNoBlock = ~uint32_t{0};
  static constexpr uint32_t kChunk = 256;  // Blocks that are allocated together, and never move.

  // A block of voxels. Members that every lookup touches come first, in one cache line.
  struct alignas(64) Block {
    uint64_t key = kNoKey;
    float count = 0;                      // Sum over all voxels.
    uint32_t scan = 0;                    // The last that put a point here.
    std::array<float, 9> fitted_count{};  // VoxelSums::count when the shape was last fitted.
    std::array<VoxelSums, 8> sums;        // Relative to the centre of the block.
    std::array<Shape, 9> shapes;          // The eight voxels' and, last, the whole block's.
  };
  struct Slot {
    uint64_t key = kNoKey;
    uint32_t block = kNoBlock;
  };

  struct Cell {  // The place of a point.
    uint64_t key;
    int voxel;
    Eigen::Vector3f offset;  // From the centre of the block.
    Eigen::Vector3d centre;
  };
  static Cell CellOf(const Eigen::Vector3d& p);
  static bool IsWithin(const Found& voxel, const Eigen::Vector3d& p);

  uint32_t FindBlock(uint64_t key) const;
  uint32_t AddBlock(uint64_t key);
  void RemoveBlock(uint32_t index);
  void GrowTable();
  void Place(const Slot& entry);
  const Shape& Fitted(Block& block, int level);
  struct Columns;  // The columns of a state.
  void Unpack(const Columns& columns, StateReader& io);
  bool AddRestored(uint32_t index, uint64_t key);
  Block& BlockAt(uint32_t index) { return chunks_[index / kChunk][index % kChunk]; }
  const Block& BlockAt(uint32_t index) const { return chunks_[index / kChunk][index % kChunk]; }

  const ShapeKind kind_;
  const LocalMapOptions options_;
  VoxelHash hash_;
  std::vector<Slot> table_;  // Open addressing, linear probing.
  std::vector<std::unique_ptr<Block[]>> chunks_;
  uint32_t allocated_ = 0;  // Blocks in use or free; those with kNoKey are free.
  std::vector<uint32_t> free_;
  size_t live_ = 0;
  uint32_t cursor_ = 0;  // Evict goes on here.
  uint32_t scan_ = 0;    // Calls of Evict.
  double reach_m_;       // options_.radius_m, or less while there are too many blocks.
};

}  // namespace isthmus::floam
