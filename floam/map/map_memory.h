// The memory of all that a session has seen so far, thinned: where a kidnapped robot is looked for.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <unordered_map>
#include <vector>

#include "core/geometry/voxel_thinner.h"
#include "core/map/submap.h"
#include "floam/map/limits.h"

namespace isthmus::floam {

struct MapMemoryOptions {
  double max_range_m = 40;  // Points farther from the keyframe that saw them are left out.
  // A cell that a submap sees forgets what the last so many submaps did not see in it: where the
  // odometry has drifted since, or things were moved.
  uint32_t fresh_submaps = 12;
  size_t max_voxels = 4'000'000;    // 12 bytes each; beyond, what was not seen for longest goes.
  double keyframe_spacing_m = 2.0;  // One keyframe per square of this size is remembered.
};

// One point per voxel of 0.2 m, in square tiles of 6.4 m and any height, in a frame of the owner's
// choice whose z points up, here called map: odom, if it is level. Memory follows the area that was
// seen, not the distance driven. Not thread safe.
class MapMemory {
 public:
  static constexpr double kCellM = 2 * kMemoryVoxelM;  // Cells of the view from above.
  static constexpr int kCells = 16;                    // Per side of a tile.
  static constexpr double kTileM = kCells * kCellM;

  // A cell of the view from above. All upright things are walls, even trees.
  enum class Cell : uint8_t { kUnknown, kFlat, kWall };

  struct TileIndex {
    int x = 0, y = 0;
    bool operator==(const TileIndex&) const = default;
  };
  static TileIndex TileAt(double x, double y);
  static uint64_t KeyOf(TileIndex index);  // Another one for every tile.

  explicit MapMemory(const MapMemoryOptions& options);

  void Add(const Submap& submap, const Pose& T_map_submap);

  bool empty() const { return tiles_.empty(); }
  size_t voxel_count() const { return voxels_; }
  size_t tile_count() const { return tiles_.size(); }

  // The latest sensor position of each square of keyframe_spacing_m, in no particular order.
  std::vector<Eigen::Vector3d> SensorPositions() const;

  // Calls `visit` with every TileIndex that the square of 2 `reach_m` about a position touches.
  template <typename Visit>
  static void ForTilesAround(const Eigen::Vector2d& position, double reach_m, Visit visit) {
    const TileIndex low = TileAt(position.x() - reach_m, position.y() - reach_m);
    const TileIndex high = TileAt(position.x() + reach_m, position.y() + reach_m);
    for (int y = low.y; y <= high.y; ++y) {
      for (int x = low.x; x <= high.x; ++x) visit(TileIndex{x, y});
    }
  }

  // Row by row (y), kCells in a row; null for a tile of which nothing is known.
  const std::array<Cell, kCells * kCells>* Cells(TileIndex index) const;

  struct SeenPoint {
    Eigen::Vector3f position;  // To 1 mm.
    bool on_wall = false;      // In a cell with a wall.
  };
  // Appends the points of a tile.
  void AppendPoints(TileIndex index, std::vector<SeenPoint>* out) const;

 private:
  struct Voxel {
    uint32_t key = 0;                 // Cell, then height, then which quarter of the cell.
    uint32_t submap = 0;              // The last that saw it.
    std::array<uint8_t, 3> offset{};  // From the voxel's low corner to the point, 1/256 voxel.
  };
  struct Tile {
    std::vector<Voxel> voxels;  // Ascending by key.
    std::array<Cell, kCells * kCells> cells{};
  };
  struct Incoming {
    uint64_t tile;
    Voxel voxel;
  };

  void Gather(const Submap& submap, const Pose& T_map_submap);
  void Merge(const Incoming* begin, const Incoming* end, Tile* tile);
  void DropStale(uint32_t submap);
  static void Classify(Tile* tile);
  void ForgetOldest();

  MapMemoryOptions options_;
  std::unordered_map<uint64_t, Tile> tiles_;
  std::unordered_map<uint64_t, Eigen::Vector3d> sensors_;  // By square.
  size_t voxels_ = 0;
  VoxelThinner thinner_;  // Scratch, as is all below.
  std::vector<Incoming> incoming_;
  std::vector<Voxel> merged_;
};

}  // namespace isthmus::floam
