// A map's tiles, one by one.
#include <absl/container/flat_hash_set.h>

#include <algorithm>
#include <utility>

#include "server/composition/tiles/tiled_map.h"

namespace isthmus::composition {
namespace {

bool IsPlacedBefore(const TilePtr& tile, const std::pair<int32_t, int32_t>& place) {
  return std::pair(tile->record().x, tile->record().y) < place;
}

TileInfo InfoOf(const Tile& tile, uint32_t component) {
  const TileRecord& record = tile.record();
  return {{component, 0, record.x, record.y},
          record.version,
          record.revision,
          record.point_count(),
          record.bounds};
}

TileInfo InfoOf(const TilePyramid::Node& node, uint32_t component, uint32_t level) {
  return {
      {component, level, node.x, node.y}, node.version, node.revision, node.points, node.bounds};
}

}  // namespace

uint32_t TiledMap::tile_levels(uint32_t component) const {
  const Component* found = Find(component);
  if (found == nullptr || found->tiles.empty()) return 0;
  return static_cast<uint32_t>(1 + found->pyramid->levels());
}

std::vector<TileInfo> TiledMap::Tiles(uint32_t component, uint32_t level) const {
  std::vector<TileInfo> infos;
  if (level >= tile_levels(component)) return infos;
  const Component& found = components_[component];
  if (level == 0) {
    for (const TilePtr& tile : found.tiles) infos.push_back(InfoOf(*tile, component));
  } else {
    for (const auto& node : found.pyramid->level(level)) {
      infos.push_back(InfoOf(node, component, level));
    }
  }
  return infos;
}

std::vector<TilePtr> TiledMap::TilesOn(const TileId& tile) const {
  std::vector<TilePtr> on;
  if (tile.level >= tile_levels(tile.component)) return on;
  const std::vector<TilePtr>& all = components_[tile.component].tiles;
  // In 64 bits: a reader may ask for any number.
  const int64_t edge = int64_t{1} << tile.level;
  const int64_t x = tile.x * edge, y = tile.y * edge;
  const auto column = [&](const TilePtr& t) { return t->record().x; };
  auto it =
      std::partition_point(all.begin(), all.end(), [&](const TilePtr& t) { return column(t) < x; });
  while (it != all.end() && column(*it) < x + edge) {
    // A column: down to where the tile begins, through it, on to the next.
    const int32_t at = column(*it);
    it = std::partition_point(
        it, all.end(), [&](const TilePtr& t) { return column(t) == at && t->record().y < y; });
    while (it != all.end() && column(*it) == at && (*it)->record().y < y + edge) {
      on.push_back(*it++);
    }
    it = std::partition_point(it, all.end(), [&](const TilePtr& t) { return column(t) == at; });
  }
  return on;
}

absl::StatusOr<TileInfo> TiledMap::FindTile(const TileId& tile) const {
  if (tile.level >= tile_levels(tile.component)) return NoTile(tile);
  const Component& found = components_[tile.component];
  if (tile.level > 0) {
    const TilePyramid::Node* node = found.pyramid->Find(tile.level, tile.x, tile.y);
    if (node == nullptr) return NoTile(tile);
    return InfoOf(*node, tile.component, tile.level);
  }
  const std::pair place(tile.x, tile.y);
  const auto it = std::lower_bound(found.tiles.begin(), found.tiles.end(), place, IsPlacedBefore);
  if (it == found.tiles.end() || std::pair((*it)->record().x, (*it)->record().y) != place) {
    return NoTile(tile);
  }
  return InfoOf(**it, tile.component);
}

// With the composer's own numbers of robots.
absl::StatusOr<std::vector<MapPoint>> TiledMap::MakeTile(const TileId& tile) const {
  std::vector<MapPoint> made;
  absl::flat_hash_set<uint64_t> seen;
  for (const TilePtr& part_of_it : TilesOn(tile)) {
    const absl::StatusOr<TilePoints> read = part_of_it->Points(tile.level);
    if (!read.ok()) return read.status();
    for (size_t part = 0; part < read->ranges.size(); ++part) {
      const uint32_t robot = part_of_it->parts()[part].robot;
      for (uint32_t i = read->ranges[part].first; i < read->ranges[part].second; ++i) {
        const TilePoint& p = (*read->points)[i];
        if (tile.level > 0) {
          const Voxel v = grid_.Find(p.x, p.y, p.z).value_or(Voxel());
          const uint64_t voxel =
              PackVoxel({v.x >> tile.level, v.y >> tile.level, v.z >> tile.level});
          if (!seen.insert(voxel).second) continue;
        }
        made.push_back({p.x, p.y, p.z, p.intensity, robot, p.label, p.stamp});
      }
    }
  }
  return made;
}

absl::StatusOr<std::vector<MapPoint>> TiledMap::ReadTile(const TileId& tile) const {
  const absl::StatusOr<TileInfo> info = FindTile(tile);
  if (!info.ok()) return info.status();
  std::vector<MapPoint> points;
  const MadeTileKey key{tile.level, tile.x, tile.y, info->version};
  if (const MadeTiles::Points found = tile.level > 0 ? made_->Find(key) : nullptr) {
    points = *found;
  } else {
    absl::StatusOr<std::vector<MapPoint>> made = MakeTile(tile);
    if (!made.ok()) return made.status();
    points = *std::move(made);
    if (tile.level > 0) made_->Put(key, std::make_shared<const std::vector<MapPoint>>(points));
  }
  for (MapPoint& point : points) point.robot = index_of_number_[point.robot];
  return points;
}

}  // namespace isthmus::composition
