// Occupancy along rays, column by column: the working memory of an OctoMap being built.
//
// The evidence is OctoMap's own (Hornung et al., "OctoMap", Autonomous Robots 2013, section 3.2):
// log-odds, one hit or miss per voxel and scan, clamped (eq. 4). Within a scan a hit outweighs
// misses. What differs is only where it is kept: updating an octree costs a walk of 16 levels per
// voxel, a dense block costs one addition, and most rays cross the same voxels again and again.
#pragma once

#include <absl/container/flat_hash_map.h>
#include <absl/container/flat_hash_set.h>

#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <vector>

#include "server/composition/occupancy/column_key.h"
#include "server/composition/occupancy/occupancy_options.h"
#include "server/composition/occupancy/packed_column.h"
#include "server/composition/occupancy/voxel_column.h"

namespace isthmus::composition {

// Not thread safe.
class EvidenceGrid {
 public:
  // A column's first submap to cast, and its evidence from before.
  struct Plan {
    static constexpr uint32_t kNever = std::numeric_limits<uint32_t>::max();
    // The submaps before this one, by number, change nothing here: their evidence is in `kept`.
    uint32_t from = 0;
    std::shared_ptr<const PackedColumn> kept = nullptr;  // Null: nothing.
  };
  // Asked once for each column that rays reach. Columns planned from kNever on stay empty.
  using Planner = std::function<Plan(const ColumnKey&)>;

  // Voxels have a corner at the origin. Of the options only resolution, range and sensor model are
  // looked at.
  EvidenceGrid(const OccupancyOptions& options, uint64_t max_bytes, Planner planner);

  // Scans that follow are of this submap; numbers must rise.
  void BeginSubmap(uint32_t number);
  // Inserts what one keyframe saw. Points of one voxel count once, with a ray to the voxel's
  // middle, as in OctoMap's discretised insertion; rays longer than the maximum range clear the way
  // up to it and hit nothing. Points that are not finite are left out. Everything within reach of
  // `origin` must be within 2^20 voxels of the origin of the grid.
  //
  // Where this takes more than `max_bytes` the last of the columns are given up, see end(). False,
  // the scan inserted in part, when one column alone does.
  bool InsertScan(const Eigen::Vector3d& origin, const std::vector<Eigen::Vector3d>& points);
  // Columns that the submap's evidence is on, those that stay empty included, in order.
  std::vector<ColumnKey> Touched() const;

  // The first of the columns that were given up: this one and all behind it are empty. Nothing:
  // none were.
  std::optional<ColumnKey> end() const { return end_; }
  // Number of columns that were given up, of those that were to change.
  uint64_t given_up() const { return given_up_; }
  // Calls visit(key, column) for all others that a submap from the planned one on touched, empties
  // them, and gives their memory back one by one. In no particular order.
  void TakeEach(const std::function<void(const ColumnKey&, PackedColumn)>& visit);

 private:
  struct Column {
    ColumnKey key;
    uint32_t from = Plan::kNever;
    uint32_t touched = Plan::kNever;  // The last submap that did.
    bool is_changed = false;
    VoxelColumn voxels;
  };

  VoxelIndex IndexOf(const Eigen::Vector3d& p) const;
  // The column, made if need be, touched by the submap under way.
  Column& Touch(const VoxelIndex& index);
  Column& Make(const ColumnKey& key);
  bool Takes(const Column& column) const { return column.from <= submap_; }
  // False, and nothing changes, when the scan under way has changed the voxel already.
  bool Update(const VoxelIndex& index, float evidence, Column* column);
  void ClearRay(const Eigen::Vector3d& from, const VoxelIndex& last);
  bool GiveUpSome();

  const double resolution_m_;
  const double max_range_m_;
  const float hit_, miss_, least_, most_;  // Log odds.
  const uint64_t max_bytes_;
  const Planner planner_;
  absl::flat_hash_map<ColumnKey, std::unique_ptr<Column>> columns_;
  Column* last_ = nullptr;  // Rays stay in a column for a while.
  uint64_t bytes_ = 0;
  std::optional<ColumnKey> end_;
  uint64_t given_up_ = 0;
  uint32_t submap_ = 0;
  uint32_t scan_ = 1;  // 1 is what was kept.
  std::vector<ColumnKey> touched_;
  // State of the scan under way; kept to spare allocations.
  std::vector<VoxelIndex> ray_ends_;
  absl::flat_hash_set<uint64_t> ends_;  // Voxels that rays end in without changing them.
};

}  // namespace isthmus::composition
