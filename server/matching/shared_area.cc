#include "server/matching/shared_area.h"

#include <absl/container/flat_hash_set.h>

#include <cmath>
#include <cstdint>

namespace isthmus::matching {

SharedArea MeasureSharedArea(const BirdsEyeCells& a, const BirdsEyeCells& b,
                             const Pose& T_level_a_level_b) {
  const double inverse_cell = 1 / a.cell_m;
  const auto key = [&](double x, double y) {
    const auto column = static_cast<int32_t>(std::floor(x * inverse_cell));
    const auto row = static_cast<int32_t>(std::floor(y * inverse_cell));
    return static_cast<uint64_t>(static_cast<uint32_t>(column)) << 32 | static_cast<uint32_t>(row);
  };
  absl::flat_hash_set<uint64_t> seen;
  seen.reserve(a.known.size());
  for (const Eigen::Vector2f& p : a.known) seen.insert(key(p.x(), p.y()));
  SharedArea shared;
  size_t count = 0;
  for (const Eigen::Vector2f& p : b.known) {
    const Eigen::Vector3d q = T_level_a_level_b * Eigen::Vector3d(p.x(), p.y(), 0);
    if (!seen.contains(key(q.x(), q.y()))) continue;
    ++count;
    shared.center += q.head<2>();
  }
  if (count > 0) shared.center /= static_cast<double>(count);
  shared.area_m2 = static_cast<double>(count) * a.cell_m * a.cell_m;
  return shared;
}

}  // namespace isthmus::matching
