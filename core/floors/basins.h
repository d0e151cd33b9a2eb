// Open ground parted at its necks.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/floors/distance.h"

namespace isthmus::floors {

// A watershed of distances from walls (Vincent and Soille, "Watersheds in digital spaces", PAMI 13,
// 1991), from the widest places down. Basins that meet become one unless their neck is narrow
// against the narrower of them. Necks are where Voronoi graphs have their critical points (Thrun,
// "Learning metric-topological maps for indoor mobile robot navigation", Artificial Intelligence
// 99, 1998).
struct Basins {
  std::vector<int32_t> labels;  // By cell; -1 where it is not open.
  std::vector<size_t> peaks;    // By label: the cell that is farthest from all walls.
};

// `squares` as SquaredDistances says it.
Basins FindBasins(const Mask& mask, const std::vector<int32_t>& squares);

}  // namespace isthmus::floors
