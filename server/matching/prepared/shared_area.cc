#include "server/matching/prepared/shared_area.h"

#include <absl/container/flat_hash_set.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace isthmus::matching {

namespace {

// The cells that a map knows.
class KnownGround {
 public:
  explicit KnownGround(const BirdsEyeCells& cells) : inverse_cell_(1 / cells.cell_m) {
    keys_.reserve(cells.known.size());
    for (const Eigen::Vector2f& p : cells.known) keys_.insert(Key(p.x(), p.y()));
  }

  bool Contains(double x, double y) const { return keys_.contains(Key(x, y)); }

 private:
  uint64_t Key(double x, double y) const {
    const auto column = static_cast<int32_t>(std::floor(x * inverse_cell_));
    const auto row = static_cast<int32_t>(std::floor(y * inverse_cell_));
    return static_cast<uint64_t>(static_cast<uint32_t>(column)) << 32 | static_cast<uint32_t>(row);
  }

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
