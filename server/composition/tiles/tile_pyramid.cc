#include "server/composition/tiles/tile_pyramid.h"

#include <algorithm>
#include <utility>

#include "core/content_hash.h"

namespace isthmus::composition {
namespace {

using Node = TilePyramid::Node;

// The last level has so many tiles at most: those around the origin never share one.
constexpr size_t kTopTiles = 4;  // Layout

using Place = std::pair<int32_t, int32_t>;
Place PlaceOf(const Node& node) { return {node.x, node.y}; }
bool IsBefore(const Node& l, const Node& r) { return PlaceOf(l) < PlaceOf(r); }
bool LiesBefore(const Node& node, const Place& place) { return PlaceOf(node) < place; }

// The tiles themselves; points are not counted.
std::vector<Node> NodesOf(const std::vector<TilePtr>& tiles) {
  std::vector<Node> nodes;
  nodes.reserve(tiles.size());
  for (const TilePtr& tile : tiles) {
    const TileRecord& record = tile->record();
    nodes.push_back({record.x, record.y, record.version, record.revision, 0, record.bounds});
  }
  return nodes;
}

// The level above one, in order; points are not counted.
std::vector<Node> Above(std::vector<Node> below) {
  for (Node& node : below) {
    // Rounded down.
    node.x >>= 1;
    node.y >>= 1;
  }
  std::stable_sort(below.begin(), below.end(), IsBefore);
  std::vector<Node> above;
  for (size_t i = 0; i < below.size();) {
    Node node = below[i];
    node.points = 0;  // The copy counts the points of the level below.
    ContentHash hash;
    for (; i < below.size() && PlaceOf(below[i]) == PlaceOf(node); ++i) {
      hash.Add(below[i].version);
      node.bounds.Extend(below[i].bounds);
    }
    node.version = hash.value();
    above.push_back(node);
  }
  return above;
}

// Adds up for each node the points that its tiles have at the level.
void CountPoints(const std::vector<TilePtr>& tiles, uint32_t level, std::vector<Node>* nodes) {
  for (const TilePtr& tile : tiles) {
    const TileRecord& record = tile->record();
    const Place place(record.x >> level, record.y >> level);
    Node& node = *std::lower_bound(nodes->begin(), nodes->end(), place, LiesBefore);
    for (const TilePart& part : record.parts) node.points += part.EndOf(level) - part.begin;
  }
}

}  // namespace

TilePyramid::TilePyramid(const std::vector<TilePtr>& tiles, int64_t revision,
                         const TilePyramid* before) {
  std::vector<Node> below = NodesOf(tiles);
  for (uint32_t level = 1; below.size() > kTopTiles; ++level) {
    below = Above(std::move(below));
    CountPoints(tiles, level, &below);
    for (Node& node : below) {
      const Node* same = before != nullptr ? before->Find(level, node.x, node.y) : nullptr;
      node.revision = same != nullptr && same->version == node.version ? same->revision : revision;
    }
    levels_.push_back(below);
  }
}

const std::vector<Node>& TilePyramid::level(uint32_t level) const {
  static const std::vector<Node> none;
  return level >= 1 && level <= levels_.size() ? levels_[level - 1] : none;
}

const Node* TilePyramid::Find(uint32_t level, int32_t x, int32_t y) const {
  const std::vector<Node>& nodes = this->level(level);
  const Place place(x, y);
  const auto it = std::lower_bound(nodes.begin(), nodes.end(), place, LiesBefore);
  return it == nodes.end() || PlaceOf(*it) != place ? nullptr : &*it;
}

}  // namespace isthmus::composition
