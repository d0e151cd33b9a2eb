// The places where parts of a floor touch.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/floors/distance.h"

namespace isthmus::floors {

// The widest place on a line along which two parts touch. Places are in cells from the lower left
// corner of the map.
struct Neck {
  int32_t a = 0, b = 0;  // Labels, the lower first.
  size_t cell = 0;
  int32_t square = 0;                        // The distance from walls, in cells, squared.
  std::array<Eigen::Vector2d, 2> ends = {};  // The nearest places of walls, on both sides.

  double Width() const;  // Cells.
};

// In the order of the labels. `labels` is -1 where `ground` is not open.
std::vector<Neck> FindNecks(const Mask& ground, const std::vector<int32_t>& squares,
                            const std::vector<int32_t>& labels);

}  // namespace isthmus::floors
