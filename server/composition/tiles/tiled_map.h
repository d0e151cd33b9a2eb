// The merged map as composition hands it out: tiles shared with the maps before and after it.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "core/map/composed_map.h"
#include "server/composition/tiles/made_tiles.h"
#include "server/composition/tiles/tile.h"
#include "server/composition/tiles/tile_pyramid.h"
#include "server/composition/voxel_thinner.h"

namespace isthmus::composition {

// Immutable; safe to read from many threads.
class TiledMap : public ComposedMap {
 public:
  struct Robot {
    RobotId id;
    uint32_t number = 0;  // As in TilePart::robot.
  };
  struct Component {
    std::vector<TilePtr> tiles;  // In order of their place; none is empty.
    uint64_t point_count = 0;
    Box bounds;
    std::shared_ptr<const TilePyramid> pyramid;  // Not null if there are tiles.
  };
  struct Scale {
    double voxel_m = 0;
    int32_t tile_voxels = 0;  // Along an edge of a tile.
  };

  // A map's knowledge of submaps beside their points.
  struct Submaps {
    std::map<SessionId, uint32_t> places = {};  // The component that each session lies in.
    uint64_t missing = 0, waiting = 0;
  };

  // `robots` in order of id; `made` is shared by the maps of a composer.
  TiledMap(int64_t revision, const std::vector<Robot>& robots, std::vector<Component> components,
           const Scale& scale, std::shared_ptr<MadeTiles> made, Submaps submaps,
           std::shared_ptr<const ComposedMap> dropped);

  int64_t revision() const override { return revision_; }
  const std::vector<RobotId>& robots() const override { return robots_; }
  uint32_t component_count() const override { return static_cast<uint32_t>(components_.size()); }
  uint64_t point_count(uint32_t component) const override;
  Box bounds(uint32_t component) const override;
  std::optional<uint32_t> component_of(const SessionId& session) const override;
  uint64_t missing_submaps() const override { return submaps_.missing; }
  uint64_t waiting_submaps() const override { return submaps_.waiting; }
  std::shared_ptr<const ComposedMap> dropped() const override { return dropped_; }
  double tile_m() const override { return scale_.tile_voxels * scale_.voxel_m; }
  double voxel_m() const override { return scale_.voxel_m; }
  uint32_t tile_levels(uint32_t component) const override;
  std::vector<TileInfo> Tiles(uint32_t component, uint32_t level) const override;
  absl::StatusOr<TileInfo> FindTile(const TileId& tile) const override;
  // Above level 0 the first point met in a voxel, as in Read, stands for it; what was made is kept
  // for a while.
  absl::StatusOr<std::vector<MapPoint>> ReadTile(const TileId& tile) const override;
  // Points come tile by tile, the same order every time. With a resolution the first point met in a
  // voxel, whoever saw it, stands for the voxel. Of tiles that lie in the region as a whole no
  // finer level of detail is read than the resolution needs. A chunk of 0 counts as 1. Nothing is
  // emitted for a component or robot that does not exist. Holds one tile at a time. Fails as
  // MapFile::Read does.
  absl::Status Read(const Region& region, size_t chunk, const Emit& emit) const override;
  // Equal where each tile lies in the region as a whole or not at all, and is one robot's, and
  // where the resolution is the map's voxel times a power of two that divides tiles. Without a
  // resolution tiles may be of many robots.
  PointBounds BoundsOf(const Region& region) const override;

  // Empty for a component that does not exist.
  const std::vector<TilePtr>& tiles(uint32_t component) const;

 private:
  const Component* Find(uint32_t component) const;  // Null: there is none.
  // The tiles of level 0 that lie on a tile, column by column.
  std::vector<TilePtr> TilesOn(const TileId& tile) const;
  absl::StatusOr<std::vector<MapPoint>> MakeTile(const TileId& tile) const;
  size_t PartsOf(const Tile& tile, int robot) const;  // `robot` -1: all.

  const int64_t revision_;
  const Submaps submaps_;
  const std::shared_ptr<const ComposedMap> dropped_;
  const Scale scale_;
  const VoxelGrid grid_;
  const std::shared_ptr<MadeTiles> made_;
  std::vector<RobotId> robots_;
  std::vector<uint32_t> index_of_number_;  // Robot::number to index into robots_.
  const std::vector<Component> components_;
};

}  // namespace isthmus::composition
