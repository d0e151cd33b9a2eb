#include "client/simulation/overlap.h"

#include <algorithm>
#include <cmath>

namespace isthmus::simulation {

void SeenSurface::Add(const Scan& scan, const Pose& T_world_sensor) {
  constexpr size_t kEvery = 8;  // Surfaces are seen many times: some of the points will do.
  const Eigen::Matrix3d rotation = T_world_sensor.RotationMatrix();
  for (size_t i = 0; i < scan.points.size(); i += kEvery) {
    const ScanPoint& p = scan.points[i];
    const Eigen::Vector3d at =
        rotation * Eigen::Vector3d(p.x, p.y, p.z) + T_world_sensor.translation();
    uint64_t key = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const auto cell = static_cast<int64_t>(std::floor(at[axis] / cell_m_));
      key = (key << 21) | (static_cast<uint64_t>(cell) & 0x1FFFFF);
    }
    cells_.insert(key);
  }
}

double SeenSurface::Overlap(const SeenSurface& a, const SeenSurface& b) {
  const bool a_is_smaller = a.cells() < b.cells();
  const SeenSurface &small = a_is_smaller ? a : b, &large = a_is_smaller ? b : a;
  if (small.cells_.empty()) return 0;
  const auto common = std::count_if(small.cells_.begin(), small.cells_.end(),
                                    [&](uint64_t cell) { return large.cells_.contains(cell); });
  return static_cast<double>(common) / static_cast<double>(small.cells());
}

}  // namespace isthmus::simulation
