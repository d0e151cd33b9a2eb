// The shape of the points around a place, at several scales.
#pragma once

#include <absl/container/flat_hash_map.h>

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "server/classes/limits.h"

namespace isthmus::classes {

// Eigenvalue features (Weinmann et al., "Semantic point cloud interpretation based on optimal
// neighborhoods, relevant features and efficient classifiers", ISPRS 2015), of standard deviations
// s1 >= s2 >= s3 along the principal directions.
struct Shape {
  float linear = 0;       // (s1 - s2) / s1.
  float planar = 0;       // (s2 - s3) / s1.
  float scattered = 0;    // s3 / s1.
  float normal_z = 0;     // |z| of the direction of s3.
  float along_z = 0;      // |z| of the direction of s1.
  float thickness_m = 0;  // s3.
  float cells = 0;        // The finest cells that have points.
  Eigen::Vector3f normal = Eigen::Vector3f::UnitZ();
};

// Sums over cells of points, each level of twice the edge. Not thread safe: shapes are computed
// when they are first asked for.
class Moments {
 public:
  explicit Moments(std::span<const Eigen::Vector3f> points);

  // The shape of the 2 x 2 x 2 cells of a level whose middle is nearest to the place. All zero
  // where no point is in them.
  Shape At(int level, const Eigen::Vector3f& place);
  // Shapes of all cells of a level, with the numbers of points in them.
  void ForEach(int level, const std::function<void(const Shape&, double points)>& visit) const;

 private:
  struct Sums {
    double n = 0;
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    std::array<double, 6> products = {};  // xx xy xz yy yz zz.
    uint32_t cells = 0;

    void Add(const Sums& other);
  };
  struct Cell {
    Eigen::Vector3i index;
    Sums sums;
  };
  // Shapes are kept, as neighbours ask for the same ones; sums of cells are, but not those of all
  // eight blocks that a cell is part of.
  struct Level {
    double edge_m = 0;
    absl::flat_hash_map<uint64_t, uint32_t> numbers;  // Cells, by index.
    std::vector<Cell> cells;
    absl::flat_hash_map<uint64_t, Shape> shapes;  // Blocks, by their lowest cell.
  };

  static void Put(const Eigen::Vector3i& index, const Sums& sums, Level* level);
  static Shape ShapeOf(const Sums& sums);

  std::array<Level, kLevels> levels_;
};

}  // namespace isthmus::classes
