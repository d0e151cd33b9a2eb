// The height of the ground under a map.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "server/matching/registration/surface.h"

namespace isthmus::matching {

// Heights on a grid in the level frame. Cells where no ground was seen take the nearest one's
// height. Immutable; safe to read from many threads.
class GroundGrid {
 public:
  GroundGrid() = default;
  // `surface` in the level frame. The lowest upward surface of a cell is ground, unless it stands
  // out from its neighbourhood (the top of a table or a car).
  GroundGrid(const std::vector<SurfacePoint>& surface, double cell_m);

  bool empty() const { return height_.empty(); }
  // The height of the ground; that of the nearest cell for places outside the grid; 0 when empty.
  float Height(float x, float y) const;

  struct Sample {
    Eigen::Vector2f position;
    float height = 0;
  };
  // Cells whose ground was seen.
  const std::vector<Sample>& seen() const { return seen_; }
  // Was ground seen in the cell there?
  bool Seen(float x, float y) const;

 private:
  int Index(float x, float y) const;
  void RejectTops();
  void Fill();

  float cell_m_ = 1;
  Eigen::Vector2f origin_ = Eigen::Vector2f::Zero();
  int width_ = 0, rows_ = 0;
  std::vector<float> height_;  // Row by row.
  std::vector<char> known_;    // Seen, not filled.
  std::vector<Sample> seen_;
};

}  // namespace isthmus::matching
