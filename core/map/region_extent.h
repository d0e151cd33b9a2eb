// The extent of a region: its box, sphere and shape, whoever saw what is there, when, and how fine.
#pragma once

#include <Eigen/Core>

#include "core/map/composed_map.h"

namespace isthmus {

// Thread safe; the region must outlive it.
class RegionExtent {
 public:
  explicit RegionExtent(const Region& region) : region_(region), has_box_(!region.box.empty()) {}

  bool is_everywhere() const {
    return !has_box_ && !region_.has_sphere && region_.shape == nullptr;
  }
  bool Contains(const Eigen::Vector3d& p) const {
    if (has_box_ && !region_.box.Contains(p)) return false;
    if (region_.has_sphere && !IsInSphere(p - region_.center)) return false;
    return region_.shape == nullptr || region_.shape->Contains(p);
  }
  // False only if nothing of the box is inside.
  bool MayTouch(const Box& box) const {
    if (has_box_ && !region_.box.Intersects(box)) return false;
    const Eigen::Vector3d nearest = region_.center.cwiseMax(box.min).cwiseMin(box.max);
    if (region_.has_sphere && !IsInSphere(nearest - region_.center)) return false;
    return region_.shape == nullptr || region_.shape->MayTouch(box);
  }
  // True only if all of the box is inside.
  bool ContainsAll(const Box& box) const {
    if (has_box_ && !(region_.box.Contains(box.min) && region_.box.Contains(box.max))) return false;
    const Eigen::Vector3d farthest =
        (box.min - region_.center).cwiseAbs().cwiseMax((box.max - region_.center).cwiseAbs());
    if (region_.has_sphere && !IsInSphere(farthest)) return false;
    return region_.shape == nullptr || region_.shape->ContainsAll(box);
  }

 private:
  bool IsInSphere(const Eigen::Vector3d& from_center) const {
    const double r = region_.radius_m;
    return r >= 0 && from_center.squaredNorm() <= r * r;
  }

  const Region& region_;
  const bool has_box_;
};

}  // namespace isthmus
