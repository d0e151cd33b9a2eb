// The merged map as readers see it: an immutable snapshot made by composition, read by queries.
#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <vector>

#include "core/cloud.h"
#include "core/geometry/shape.h"
#include "core/ids.h"
#include "core/map/submap.h"
#include "core/pose.h"

namespace isthmus {

// A submap and where it lies in its component's map frame. Its points are fetched when they are
// needed, see SubmapReader.
struct PlacedSubmap {
  std::shared_ptr<const SubmapInfo> submap;
  uint32_t component = 0;
  Pose T_map_submap;
};

// A square of one component's map, unbounded in z: of level L, x to x + 1 and y to y + 1 times the
// edge of a tile times 2^L.
struct TileId {
  uint32_t component = 0, level = 0;
  int32_t x = 0, y = 0;

  friend auto operator<=>(const TileId&, const TileId&) = default;
  friend bool operator==(const TileId&, const TileId&) = default;
};

struct TileInfo {
  TileId id;
  uint64_t version = 0;   // Tiles of one version hold the same points.
  int64_t revision = 0;   // Of the map in which it was so first.
  uint64_t points = 0;    // Of a level above 0 an upper bound.
  Box bounds;             // Of the points, map frame.
};

// The part of the map to read. Everything given must hold.
struct Region {
  Box box;  // In the map frame; ignored when empty.
  bool has_sphere = false;
  Eigen::Vector3d center = Eigen::Vector3d::Zero();
  double radius_m = 0;
  uint32_t component = 0;
  int robot = -1;           // Index into ComposedMap::robots(); -1 for all.
  double resolution_m = 0;  // Thinned further to one point per such voxel; 0: as composed.
  std::shared_ptr<const Shape> shape = nullptr;  // Map frame; null: everywhere.
  // MapPoint::stamp, both ends included.
  uint32_t seen_from = 0, seen_to = std::numeric_limits<uint32_t>::max();
  std::function<bool(const MapPoint&)> keep = nullptr;  // Null: all. Asked before thinning.
  uint64_t skip = 0;  // So many of the points that would come first do not.
  std::function<bool()> keep_on = nullptr;  // Asked between tiles; false ends it, which is no error.
};

// Safe to read from many threads while newer ones are made.
class ComposedMap {
 public:
  // Receives a chunk; returns false to stop reading.
  using Emit = std::function<bool(const std::vector<MapPoint>&)>;

  virtual ~ComposedMap() = default;
  virtual int64_t revision() const = 0;
  // Robots in the map, sorted; MapPoint::robot indexes this.
  virtual const std::vector<RobotId>& robots() const = 0;
  virtual uint32_t component_count() const = 0;
  // 0 and an empty box for a component that does not exist.
  virtual uint64_t point_count(uint32_t component) const = 0;
  virtual Box bounds(uint32_t component) const = 0;
  // OK, or why there is nothing to read yet: Unavailable while the map of a store is composed for
  // the first time after a start, naming how far it has come.
  virtual absl::Status ready() const { return absl::OkStatus(); }
  // Placed submaps that could not be read and are missing from the map.
  virtual uint64_t missing_submaps() const { return 0; }
  // Calls `emit` with chunks of at most `chunk` points until done or it returns false, which is no
  // error. Anything but OK means that points are missing from what was emitted: ready(), or points
  // could not be read back from where they are kept.
  virtual absl::Status Read(const Region& region, size_t chunk, const Emit& emit) const = 0;

  // Edges of a voxel and of a tile of level 0; 0 where there are none.
  virtual double voxel_m() const { return 0; }
  virtual double tile_m() const { return 0; }
  // Levels 0 to n - 1, of which the last has at most four tiles; 0 for a component without any.
  virtual uint32_t tile_levels(uint32_t) const { return 0; }
  // In order of their ids.
  virtual std::vector<TileInfo> Tiles(uint32_t, uint32_t) const { return {}; }
  // NotFound: no such tile.
  virtual absl::StatusOr<TileInfo> FindTile(const TileId&) const {
    return absl::NotFoundError("this map has no tiles");
  }
  // In the order in which Read has them. NotFound: no such tile; else fails as Read does.
  virtual absl::StatusOr<std::vector<MapPoint>> ReadTile(const TileId&) const {
    return absl::NotFoundError("this map has no tiles");
  }
  // That the tile's points came from, in order.
  virtual std::vector<SubmapId> TileSubmaps(const TileId&) const { return {}; }
};

}  // namespace isthmus
