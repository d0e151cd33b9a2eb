#include "server/composition/tiles/tile_limit.h"

#include <algorithm>
#include <functional>

namespace isthmus::composition {

uint64_t FewestPoints(std::vector<uint64_t> points_of_tiles, size_t max_tiles) {
  if (points_of_tiles.size() <= max_tiles) return 1;
  const auto first_beyond = points_of_tiles.begin() + static_cast<ptrdiff_t>(max_tiles);
  std::nth_element(points_of_tiles.begin(), first_beyond, points_of_tiles.end(), std::greater<>());
  return *first_beyond + 1;
}

void TileLimit::Add(const TileKey& tile, uint64_t points) { points_on_[tile] += points; }

void TileLimit::Remove(const TileKey& tile, uint64_t points) {
  const auto it = points_on_.find(tile);
  if (it == points_on_.end()) return;
  it->second -= std::min(it->second, points);
  if (it->second == 0) points_on_.erase(it);
}

bool TileLimit::Update() {
  const bool had_room = has_room_for_all();
  fewest_ = 1;
  if (points_on_.size() > max_tiles_) {
    std::vector<uint64_t> points;
    points.reserve(points_on_.size());
    for (const auto& [tile, count] : points_on_) points.push_back(count);
    fewest_ = FewestPoints(std::move(points), max_tiles_);
  }
  return !(had_room && has_room_for_all());
}

bool TileLimit::Stays(const TileKey& tile) const {
  const auto it = points_on_.find(tile);
  return it != points_on_.end() && it->second >= fewest_;
}

}  // namespace isthmus::composition
