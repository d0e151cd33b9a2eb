#include "core/floors/clutter.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/floors/limits.h"

namespace isthmus::floors {
namespace {

// Cells that are not open and hang together, at corners too.
class Blob {
 public:
  // Finds the blob around a cell; `seen` becomes 1 on it.
  void Find(const Mask& mask, size_t first, std::vector<uint8_t>* seen) {
    cells_.assign(1, first);
    low_ = {mask.width, mask.height};
    high_ = {0, 0};
    (*seen)[first] = 1;
    for (size_t next = 0; next < cells_.size(); ++next) {
      const Cell at = mask.At(cells_[next]);
      low_ = {std::min(low_.x, at.x), std::min(low_.y, at.y)};
      high_ = {std::max(high_.x, at.x), std::max(high_.y, at.y)};
      TakeAround(mask, at, seen);
    }
  }

  // True if it does not reach the map's edge and is no larger than that, cells.
  bool IsLoose(const Mask& mask, double largest) const {
    const bool is_inside =
        low_.x > 0 && low_.y > 0 && high_.x + 1 < mask.width && high_.y + 1 < mask.height;
    return is_inside && std::hypot(high_.x - low_.x + 1, high_.y - low_.y + 1) <= largest;
  }
  const std::vector<size_t>& cells() const { return cells_; }

 private:
  void TakeAround(const Mask& mask, const Cell& at, std::vector<uint8_t>* seen) {
    for (int64_t y = at.y - 1; y <= at.y + 1; ++y) {
      for (int64_t x = at.x - 1; x <= at.x + 1; ++x) {
        if (!mask.Has(x, y) || (*seen)[mask.Index(x, y)] != 0) continue;
        (*seen)[mask.Index(x, y)] = 1;
        cells_.push_back(mask.Index(x, y));
      }
    }
  }

  std::vector<size_t> cells_;
  Cell low_, high_;
};

// The open parts within `reach` of where a disc of that radius fits, cells.
Mask Opening(const Mask& mask, const std::vector<int32_t>& squares, double radius, double reach) {
  const double square = radius * radius;
  Mask part{mask.width, mask.height, std::vector<uint8_t>(mask.open.size()), true};
  for (size_t i = 0; i < part.open.size(); ++i) part.open[i] = squares[i] > square ? 0 : 1;
  const std::vector<int32_t> off = SquaredDistances(part);
  for (size_t i = 0; i < part.open.size(); ++i)
    part.open[i] = off[i] <= reach * reach ? mask.open[i] : 0;
  return part;
}

}  // namespace

Mask OpenGround(const GridMap& map) {
  Mask mask{map.width, map.height, {}};
  mask.open.reserve(map.cells.size());
  for (const GridCell cell : map.cells) mask.open.push_back(cell == GridCell::kFree ? 1 : 0);
  std::vector<uint8_t> seen = mask.open;
  Blob blob;
  for (size_t i = 0; i < seen.size(); ++i) {
    if (seen[i] != 0) continue;
    blob.Find(mask, i, &seen);
    if (!blob.IsLoose(mask, kLooseM / map.resolution_m)) continue;
    for (const size_t cell : blob.cells()) mask.open[cell] = 1;
  }
  return mask;
}

Solids SolidsOf(const Mask& ground, double resolution_m) {
  Mask solid = ground;
  solid.is_open_beyond = true;
  for (uint8_t& open : solid.open) open ^= 1;
  const std::vector<int32_t> squares = SquaredDistances(solid);
  const double thin = kThickestWallM / 2 / resolution_m;
  const double thick = kThickestFurnitureM / 2 / resolution_m;
  // Corners of things, in which no disc fits, are as thick as these.
  Solids solids{Opening(solid, squares, thin, std::numbers::sqrt2 * thin),
                Opening(solid, squares, thick, thick)};
  for (size_t i = 0; i < solid.open.size(); ++i) {
    solids.furniture.open[i] = solids.thick.open[i] & (solids.furniture.open[i] ^ 1);
  }
  return solids;
}

}  // namespace isthmus::floors
