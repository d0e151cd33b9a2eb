// Convex hulls of parts of a floor.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "core/floors/distance.h"

namespace isthmus::floors {

using Hull = std::vector<Eigen::Vector2d>;  // Cells, counterclockwise.

// By Andrew's monotone chain ("Another efficient algorithm for convex hulls in two dimensions",
// Information Processing Letters 9, 1979).
Hull HullOf(std::vector<Eigen::Vector2d> points);

// Hulls of the cells of each label.
std::vector<Hull> HullsOf(const Mask& ground, const std::vector<int32_t>& labels, size_t count);

// The share of the hull's area where something holds, by places in even rows.
double ShareOf(const Hull& hull, const std::function<bool(const Cell& cell)>& holds);

}  // namespace isthmus::floors
