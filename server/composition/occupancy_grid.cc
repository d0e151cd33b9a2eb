#include "server/composition/occupancy_grid.h"

#include <algorithm>
#include <cmath>

#include "server/composition/voxel_thinner.h"

namespace isthmus::composition {

OccupancyGrid::OccupancyGrid(double resolution_m, double max_range_m, uint64_t max_bytes,
                             const SensorEvidence& evidence, const Region& region)
    : resolution_m_(resolution_m),
      max_range_m_(max_range_m),
      max_bytes_(max_bytes),
      evidence_(evidence),
      region_(region),
      is_bounded_(!region.box.empty() || region.has_sphere || region.shape != nullptr) {}

bool OccupancyGrid::IsWanted(const Index& index) const {
  const Eigen::Vector3d middle = (index.cast<double>().array() + 0.5) * resolution_m_;
  if (!region_.box.empty() && !region_.box.Contains(middle)) return false;
  if (region_.shape != nullptr && !region_.shape->Contains(middle)) return false;
  return !region_.has_sphere || (middle - region_.center).norm() <= region_.radius_m;
}

OccupancyGrid::Index OccupancyGrid::IndexOf(const Eigen::Vector3d& p) const {
  return (p / resolution_m_).array().floor().cast<int32_t>();
}

OccupancyGrid::Cell& OccupancyGrid::CellAt(const Index& index) {
  // Shifting a negative number rounds down, as a block's number must.
  const uint64_t key = PackVoxel({index.x() >> kBits, index.y() >> kBits, index.z() >> kBits});
  if (key != last_key_) {
    std::unique_ptr<Block>& block = blocks_[key];
    if (!block) block = std::make_unique<Block>();
    last_key_ = key;
    last_block_ = block.get();
  }
  return (*last_block_)[(index.x() & kMask) | (index.y() & kMask) << kBits |
                        (index.z() & kMask) << 2 * kBits];
}

bool OccupancyGrid::Update(const Index& index, float evidence) {
  // As though it had taken it: the ray to a hit outside clears the way inside.
  if (is_bounded_ && !IsWanted(index)) return true;
  Cell& cell = CellAt(index);
  if (cell.scan == scan_) return false;
  if (cell.scan == 0) {
    cell.log_odds = 0;
    ++known_voxels_;
  }
  cell.scan = scan_;
  cell.log_odds = std::clamp(cell.log_odds + evidence, evidence_.min, evidence_.max);
  return true;
}

bool OccupancyGrid::InsertScan(const Eigen::Vector3d& origin,
                               const std::vector<Eigen::Vector3d>& points) {
  ++scan_;
  ray_ends_.clear();
  cut_ends_.clear();
  // Hits first: a miss of the same scan then finds its voxel taken.
  for (const Eigen::Vector3d& p : points) {
    const Eigen::Vector3d ray = p - origin;
    const double range = ray.norm();
    if (!std::isfinite(range)) continue;
    const bool hit = range <= max_range_m_;
    const Index index = IndexOf(hit ? p : origin + ray * (max_range_m_ / range));
    const bool is_new = hit ? Update(index, evidence_.hit)
                            : cut_ends_.insert(PackVoxel({index.x(), index.y(), index.z()})).second;
    // One ray per voxel, to its middle, whichever of its points came first.
    if (is_new) ray_ends_.push_back((index.cast<double>().array() + 0.5) * resolution_m_);
  }
  for (const Eigen::Vector3d& end : ray_ends_) {
    ClearRay(origin, end);
    if (bytes() > max_bytes_) return false;
  }
  return true;
}

// Amanatides and Woo, "A fast voxel traversal algorithm for ray tracing" (1987). The voxel of `to`
// itself is not cleared.
void OccupancyGrid::ClearRay(const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
  const Eigen::Vector3d ray = to - from;
  Index index = IndexOf(from);
  const Index last = IndexOf(to);
  Eigen::Vector3d next, delta;  // Share of the ray at the next face per axis, and between faces.
  Index step;
  for (int axis = 0; axis < 3; ++axis) {
    step[axis] = ray[axis] > 0 ? 1 : -1;
    const double face = resolution_m_ * (index[axis] + (ray[axis] > 0));
    const bool parallel = ray[axis] == 0;
    next[axis] =
        parallel ? std::numeric_limits<double>::infinity() : (face - from[axis]) / ray[axis];
    delta[axis] = parallel ? 0 : resolution_m_ / std::abs(ray[axis]);
  }
  // As many faces as lie between both ends: rounding can neither overshoot nor loop for ever.
  for (int faces = (last - index).cwiseAbs().sum(); faces > 0; --faces) {
    Update(index, evidence_.miss);
    const int axis =
        next.x() < next.y() ? (next.x() < next.z() ? 0 : 2) : (next.y() < next.z() ? 1 : 2);
    index[axis] += step[axis];
    next[axis] += delta[axis];
  }
}

}  // namespace isthmus::composition
