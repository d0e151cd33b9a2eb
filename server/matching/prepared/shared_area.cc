#include "server/matching/prepared/shared_area.h"

#include <absl/container/flat_hash_set.h>

#include <algorithm>
#include <cstdint>

#include "server/matching/registration/voxel_key.h"

namespace isthmus::matching {

namespace {

// The cells that a map knows.
class KnownGround {
 public:
  explicit KnownGround(const BirdsEyeCells& cells) : inverse_cell_(1 / cells.cell_m) {
    keys_.reserve(cells.known.size());
    for (const Eigen::Vector2f& p : cells.known) keys_.insert(CellKey(p.x(), p.y(), inverse_cell_));
  }

  bool Contains(double x, double y) const { return keys_.contains(CellKey(x, y, inverse_cell_)); }

 private:
  const double inverse_cell_;
  absl::flat_hash_set<uint64_t> keys_;
};

}  // namespace

SharedArea MeasureSharedArea(const BirdsEyeCells& a, const BirdsEyeCells& b,
                             const Pose& T_level_a_level_b) {
  const KnownGround ground(a);
  SharedArea shared;
  size_t count = 0;
  for (const Eigen::Vector2f& p : b.known) {
    const Eigen::Vector3d q = T_level_a_level_b * Eigen::Vector3d(p.x(), p.y(), 0);
    if (!ground.Contains(q.x(), q.y())) continue;
    ++count;
    shared.center += q.head<2>();
  }
  if (count > 0) shared.center /= static_cast<double>(count);
  const size_t most = std::max(a.known.size(), b.known.size());
  if (most > 0) shared.share = static_cast<double>(count) / static_cast<double>(most);
  shared.area_m2 = static_cast<double>(count) * a.cell_m * a.cell_m;
  return shared;
}

}  // namespace isthmus::matching
