// Bird's-eye images: where a map has walls, which way they face, and where it is free.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <vector>

#include "server/matching/search/wall_map.h"

namespace isthmus::matching {

// A map's occupied and free cells in its level frame, as lists, ready to be turned.
struct BirdsEyeCells {
  struct Wall {
    Eigen::Vector2f position;  // Centre of the cell.
    Eigen::Vector2f normal;    // Mean normal times weight.
    float weight = 0;          // (0, 1]: how much of the height band the wall fills.
  };
  double cell_m = 0;
  std::vector<Wall> walls;
  std::vector<Eigen::Vector2f> free;   // Centres; never a wall's cell or its neighbour.
  std::vector<Eigen::Vector2f> known;  // Centres of all cells that are walls or were looked across.

  // Circle around everything: every turned image fits its square.
  Eigen::Vector2f center = Eigen::Vector2f::Zero();
  float radius = 0;
  // Sets the circle.
  void Enclose();
};

// `cell_m`, or doubled so often that the correlation of the two maps' images has no more than four
// million shifts: two routes of 1 km each at cells of 1 m. Larger ones would take gigabytes.
double CellThatFits(const WallMap& a, const WallMap& b, const SceneScale& scale, double cell_m);

// Empty for a map without walls in the band. Takes memory for the square around the map,
// so `cell_m` is not to be less than half of what fits.
BirdsEyeCells MakeBirdsEyeCells(const WallMap& map, const SceneScale& scale, double cell_m);

// Four planes whose products with another map's, summed over the planes, are the score of a
// placement: walls that face the same way, walls at all, and walls in the other's free space.
struct BirdsEyeImage {
  enum Plane { kNormalX, kNormalY, kWall, kFree, kPlanes };
  Eigen::Vector2f origin = Eigen::Vector2f::Zero();  // Corner of cell (0, 0).
  float cell_m = 1;
  int width = 0, rows = 0;
  std::array<std::vector<float>, kPlanes> planes;  // Row by row.
};

// The cell of a row of `size` cells that `at` lies in, counted in cells. Far from the origin a
// float rounds by more than a cell: what it puts outside is taken into the nearest cell.
inline int CellAt(float at, int size) {
  return static_cast<int>(std::clamp(at, 0.0f, static_cast<float>(size - 1)));
}

// The binomial kernel, its peak at 1: one pass of [1/2 1 1/2] along and one across.
void Blur(int width, int rows, std::vector<float>* plane);

// The image that stays: blurred, so that neighbours of a wall agree a little, and with the weights
// of the score folded in.
BirdsEyeImage MakeReferenceImage(const BirdsEyeCells& cells, double free_space_weight);

}  // namespace isthmus::matching
