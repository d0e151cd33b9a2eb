// The merged map as composition hands it out: tiles shared with the maps before and after it.
#pragma once

#include <cstdint>
#include <vector>

#include "core/map/composed_map.h"
#include "server/composition/tiles/tile.h"

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
  };

  // `robots` in order of id.
  TiledMap(int64_t revision, const std::vector<Robot>& robots, std::vector<Component> components,
           uint64_t missing_submaps = 0);

  int64_t revision() const override { return revision_; }
  const std::vector<RobotId>& robots() const override { return robots_; }
  uint32_t component_count() const override { return static_cast<uint32_t>(components_.size()); }
  uint64_t point_count(uint32_t component) const override;
  Box bounds(uint32_t component) const override;
  uint64_t missing_submaps() const override { return missing_submaps_; }
  // Points come tile by tile, the same order every time. With a resolution the first point met in a
  // voxel, whoever saw it, stands for the voxel. A chunk of 0 counts as 1. Nothing is emitted for a
  // component or robot that does not exist. Holds one tile at a time. Fails as SpillFile::Read
  // does.
  absl::Status Read(const Region& region, size_t chunk, const Emit& emit) const override;

  // Empty for a component that does not exist.
  const std::vector<TilePtr>& tiles(uint32_t component) const;

 private:
  bool HasPointsOf(const Tile& tile, int robot) const;  // Of all robots: -1.

  const int64_t revision_;
  const uint64_t missing_submaps_;
  std::vector<RobotId> robots_;
  std::vector<uint32_t> index_of_number_;  // Robot::number to index into robots_.
  const std::vector<Component> components_;
};

}  // namespace isthmus::composition
