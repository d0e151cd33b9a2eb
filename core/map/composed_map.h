// The merged map as readers see it: an immutable snapshot made by composition, read by queries.
#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>
#include <absl/strings/str_cat.h>

#include <compare>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <vector>

#include "core/cloud.h"
#include "core/geometry/shape.h"
#include "core/ids.h"
#include "core/map/map_name.h"
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

// The part of the map to read. Everything given must hold.
struct Region {
  Box box;  // In the map frame; ignored when empty.
  bool has_sphere = false;
  Eigen::Vector3d center = Eigen::Vector3d::Zero();
  double radius_m = 0;
  uint32_t component = 0;
  int robot = -1;  // Index into ComposedMap::robots(); -1 for all.
  // Thinned further to one point per such voxel; 0: as composed. The more often two goes into it,
  // in voxels of the map, the less has to be read: of 1.6 m at 0.1 m a hundredth, of 0.5 m all.
  double resolution_m = 0;
  std::shared_ptr<const Shape> shape = nullptr;  // Map frame; null: everywhere.
  // MapPoint::stamp, both ends included.
  uint32_t seen_from = 0, seen_to = std::numeric_limits<uint32_t>::max();
  PointClasses classes;                                 // MapPoint::label.
  std::function<bool(const MapPoint&)> keep = nullptr;  // Null: all. Asked before thinning.
  uint64_t skip = 0;                        // So many of the points that would come first do not.
  std::function<bool()> keep_on = nullptr;  // Asked between tiles; false ends it, no error.
};

// A square of a component's map, of any height: tile (x, y) of a level covers [x, x + 1) times
// [y, y + 1) of its edge, tile_m * 2^level. Level 0 is what the map is made of; a tile of a higher
// level is all that lies on it, with one point per voxel of voxel_m * 2^level.
struct TileId {
  uint32_t component = 0, level = 0;
  int32_t x = 0, y = 0;

  friend auto operator<=>(const TileId&, const TileId&) = default;
  friend bool operator==(const TileId&, const TileId&) = default;
};

// The number of points that a region has, as far as it is known without reading them.
struct PointBounds {
  uint64_t least = 0, most = std::numeric_limits<uint64_t>::max();
};

struct TileInfo {
  TileId id;
  // The content's version: robots by name, points with all their fields. Equal content has an equal
  // version, in another map, after a restart, and after an undo that brings it back.
  uint64_t version = 0;
  // The map since which the content has been so; after a start, the first map or a newer one.
  int64_t revision = 0;
  uint64_t points = 0;  // Above level 0: at most.
  Box bounds;           // Around the points, map frame; above level 0 around what they stand for.
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
  // The component that the session lies in here; nothing for one that does not.
  virtual std::optional<uint32_t> component_of(const SessionId& /*session*/) const { return {}; }
  // The component that is meant, whatever others are called by now; fails as isthmus::NumberOf.
  absl::StatusOr<uint32_t> NumberOf(const MapName& name) const {
    return isthmus::NumberOf(name, component_count(),
                             [this](const SessionId& session) { return component_of(session); });
  }
  // OK, or why there is nothing to read yet: Unavailable while the map of a store is composed for
  // the first time after a start, naming how far it has come.
  virtual absl::Status ready() const { return absl::OkStatus(); }
  // Placed submaps that could not be read and are missing from the map.
  virtual uint64_t missing_submaps() const { return 0; }
  // Placed submaps whose turn to be composed comes later: another map of this revision has them.
  virtual uint64_t waiting_submaps() const { return 0; }
  // Points that were measured but are not in the map because other looks went through them: people,
  // cars, things taken away. With the robots and components of the map; null if nothing was asked
  // for it.
  virtual std::shared_ptr<const ComposedMap> dropped() const { return nullptr; }

  // Edges of a tile of level 0 and of a voxel. 0 where a map has no tiles.
  virtual double tile_m() const { return 0; }
  virtual double voxel_m() const { return 0; }
  // Levels are 0 up to one below this; the last has four tiles at most. 0 for a component that does
  // not exist.
  virtual uint32_t tile_levels(uint32_t /*component*/) const { return 0; }
  // In order of x, then y; none is without points. Empty for a component or level that does not
  // exist.
  virtual std::vector<TileInfo> Tiles(uint32_t /*component*/, uint32_t /*level*/) const {
    return {};
  }
  // NotFound where there is no such tile; else fails as Read does. A tile of level 0 has a point
  // per voxel and robot, robot by robot, each robot's from coarse to fine.
  virtual absl::StatusOr<TileInfo> FindTile(const TileId& tile) const { return NoTile(tile); }
  virtual absl::StatusOr<std::vector<MapPoint>> ReadTile(const TileId& tile) const {
    return NoTile(tile);
  }

  // Calls `emit` with chunks of at most `chunk` points until done or it returns false, which is no
  // error. Anything but OK means that points are missing from what was emitted: ready(), or points
  // could not be read back from where they are kept.
  virtual absl::Status Read(const Region& region, size_t chunk, const Emit& emit) const = 0;
  // Bounds of what Read gives where `skip` is 0. Reads no points.
  virtual PointBounds BoundsOf(const Region& /*region*/) const { return {}; }

 protected:
  static absl::Status NoTile(const TileId& tile) {
    return absl::NotFoundError(absl::StrCat("no tile ", tile.x, ", ", tile.y, " at level ",
                                            tile.level, " of component ", tile.component,
                                            ": nothing was seen there, or it is gone"));
  }
};

}  // namespace isthmus
