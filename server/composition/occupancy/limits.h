// Judged limits of kept occupancy.
#pragma once

#include <cstddef>

namespace isthmus::composition {

// Rays are cast so many times at most for one file, each time into as many columns as memory has
// room for: with the 1 GiB of OccupancyOptions a map that takes 16 GB of voxels, which is minutes
// of work. More, and a request that is too large is refused only after hours.
inline constexpr int kMostCastings = 32;

// If more than one part in so many of the submaps came or moved, all is cast anew, in one reading:
// a search for the columns that are left costs a reading of its own, and few are.
inline constexpr size_t kNewParts = 2;

// Sets of columns that are kept, of different resolutions, ranges, components and robots: one that
// is asked for again and again, and some that people try. Memory is bounded by itself.
inline constexpr size_t kKeptLayers = 8;

}  // namespace isthmus::composition
