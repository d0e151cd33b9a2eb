// Distances of the cells of a grid from what is not free.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace isthmus::floors {

struct Cell {
  int64_t x = 0, y = 0;
};

// Cells that are open or not, row by row.
struct Mask {
  int64_t width = 0, height = 0;
  std::vector<uint8_t> open;    // 0 or 1.
  bool is_open_beyond = false;  // All beyond its edges is open, or nothing.

  size_t Index(int64_t x, int64_t y) const { return static_cast<size_t>(y * width + x); }
  Cell At(size_t index) const {
    return {static_cast<int64_t>(index) % width, static_cast<int64_t>(index) / width};
  }
  bool Has(int64_t x, int64_t y) const { return x >= 0 && y >= 0 && x < width && y < height; }
  bool IsOpen(int64_t x, int64_t y) const { return Has(x, y) && open[Index(x, y)] != 0; }
};

// Squares of the distances, in cells, from the middle of each cell to the middle of the nearest
// that is not open; 0 for these, more than any map is wide if there is none. Exact, in time linear
// in cells (Felzenszwalb and Huttenlocher, "Distance transforms of sampled functions", Theory of
// Computing 8, 2012).
std::vector<int32_t> SquaredDistances(const Mask& mask);

}  // namespace isthmus::floors
