// A walk along a ray through voxels that can leap over columns of them.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "server/composition/occupancy/column_key.h"

namespace isthmus::composition {

// Amanatides and Woo, "A fast voxel traversal algorithm for ray tracing" (1987). Where the ray
// meets its n-th face of an axis is computed from n, never summed up: so a leap arrives exactly
// where single steps would have, whatever was rounded. Not thread safe.
class VoxelRay {
 public:
  // `first` and `last` are the voxels of `from` and `to`.
  VoxelRay(const Eigen::Vector3d& from, const Eigen::Vector3d& to, const VoxelIndex& first,
           const VoxelIndex& last, double resolution_m)
      : index_(first), faces_((last - first).cwiseAbs().sum()) {
    const Eigen::Vector3d ray = to - from;
    for (int axis = 0; axis < 3; ++axis) {
      const bool parallel = ray[axis] == 0, forward = ray[axis] > 0;
      const double face = resolution_m * (first[axis] + forward);
      step_[axis] = forward ? 1 : -1;
      first_[axis] = next_[axis] =
          parallel ? std::numeric_limits<double>::infinity() : (face - from[axis]) / ray[axis];
      delta_[axis] = parallel ? 0 : resolution_m / std::abs(ray[axis]);
    }
  }

  // True in the last voxel. It crosses as many faces as lie between both ends: rounding can neither
  // overshoot nor loop for ever.
  bool done() const { return faces_ <= 0; }
  const VoxelIndex& index() const { return index_; }

  // Must not be done.
  void Step() {
    const int axis =
        next_[0] < next_[1] ? (next_[0] < next_[2] ? 0 : 2) : (next_[1] < next_[2] ? 1 : 2);
    Cross(axis, 1);
    --faces_;
  }

  // As many steps as lead out of the column that it is in, or to the end.
  void LeaveColumn() {
    const int32_t to_x = FacesOut(0), to_y = FacesOut(1);
    const double at_x = Meets(0, to_x - 1), at_y = Meets(1, to_y - 1);
    const int out = at_x < at_y ? 0 : 1;  // At a tie y comes first, as in Step.
    const double at = std::min(at_x, at_y);
    if (at == std::numeric_limits<double>::infinity()) {
      faces_ = 0;  // Straight up or down.
      return;
    }
    int32_t crossed = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const int32_t faces =
          axis == out ? (out == 0 ? to_x : to_y) : FacesBefore(axis, at, axis > out);
      Cross(axis, faces);
      crossed += faces;
    }
    faces_ -= std::min(crossed, faces_);
  }

 private:
  // Share of the ray at the n-th face from here, the next being the 0-th.
  double Meets(int axis, int32_t n) const {
    return first_[axis] + (crossed_[axis] + n) * delta_[axis];
  }
  void Cross(int axis, int32_t faces) {
    index_[axis] += faces * step_[axis];
    crossed_[axis] += faces;
    next_[axis] = Meets(axis, 0);
  }
  int32_t FacesOut(int axis) const {
    const int32_t inside = index_[axis] & (kColumnEdge - 1);
    return step_[axis] > 0 ? kColumnEdge - inside : inside + 1;
  }
  // Faces of an axis that Step would cross before it crosses one at `at`.
  int32_t FacesBefore(int axis, double at, bool wins_ties) const {
    if (delta_[axis] == 0) return 0;
    const auto before = [&](int32_t n) {
      const double meets = Meets(axis, n);
      return wins_ties ? meets <= at : meets < at;
    };
    const double guess = (at - next_[axis]) / delta_[axis];
    auto n = static_cast<int32_t>(std::clamp(guess, 0., static_cast<double>(faces_)));
    while (n > 0 && !before(n - 1)) --n;
    while (n <= faces_ && before(n)) ++n;
    return n;
  }

  VoxelIndex index_;
  int32_t faces_;  // Left to cross.
  std::array<int32_t, 3> step_;
  std::array<double, 3> first_, delta_, next_;
  std::array<double, 3> crossed_ = {};  // Faces; whole numbers.
};

}  // namespace isthmus::composition
