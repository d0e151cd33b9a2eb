// The ground that robots drove on, below and between the places where their sensors were.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "core/map/free_space.h"

namespace isthmus::floors {

// The median height of the stations above the highest occupied voxel under each, no deeper than
// kDeepestGroundM, metres; kUnknownSensorHeightM where nothing is under any.
double SensorHeight(const std::vector<VoxelCube>& leaves, double resolution_m,
                    const std::vector<Eigen::Vector3d>& stations);

// The height of the station nearest to each cell, to about half a metre. Immutable.
class HeightField {
 public:
  // `origin`: lower left corner of the cells. At least one station.
  HeightField(const Eigen::Vector2d& origin, double resolution_m, int64_t width, int64_t height,
              const std::vector<Eigen::Vector3d>& stations);

  double At(int64_t x, int64_t y) const {
    return heights_[static_cast<size_t>(y / step_ * columns_ + x / step_)];
  }

 private:
  int64_t step_ = 1;  // Cells along each side of a coarse cell.
  int64_t columns_ = 0, rows_ = 0;
  std::vector<double> heights_;
};

}  // namespace isthmus::floors
