// Outlines of rooms on a grid.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "core/floors/distance.h"

namespace isthmus::floors {

using Outline = std::vector<Eigen::Vector2d>;  // Closed: the first corner follows the last.

// Outlines of each label, in cells from the lower left corner: the outer one first and
// counterclockwise, around its holes clockwise. A label's cells hang together by their sides.
// Outlines leave the cells' edges by a cell and a half at most (Douglas and Peucker, "Algorithms
// for the reduction of the number of points required to represent a digitized line", Cartographica
// 10, 1973), as long as none of the label's touches itself or another.
std::vector<std::vector<Outline>> OutlinesOf(const Mask& ground, const std::vector<int32_t>& labels,
                                             size_t count);

// Positive if counterclockwise.
double SignedArea(const Outline& outline);

}  // namespace isthmus::floors
