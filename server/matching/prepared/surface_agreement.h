// The agreement of surfaces laid on each other: what of one is seen by the other, what lies on it,
// how tightly.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/pose.h"
#include "server/matching/prepared/distinctive.h"
#include "server/matching/prepared/prepared_submap.h"

namespace isthmus::matching {

// The agreement of a submap's surface with a whole map. Sums, so that those of submaps can be
// added.
struct SurfaceAgreement {
  int64_t asked = 0;      // Points of the submap that were asked,
  int64_t near = 0;       // that have the map within a metre,
  int64_t on = 0;         // that lie on it,
  double squared_m2 = 0;  // and the squared distances of these along the normals.
  // The same of what stands upright: floors lie on floors wherever one is.
  int64_t near_upright = 0, on_upright = 0;
  int64_t on_distinctive = 0;  // Points on it, distinctive in both maps; 0 if not asked for.
  // Sum over the points on it of J^T n n^T J, J = [I, -[p]x], p in the common frame: the
  // information of a twist about its origin per squared metre.
  Matrix6d scatter = Matrix6d::Zero();

  double overlap() const;  // On, of those asked; 0 without any, as the next.
  double ratio() const;    // On, of those near.
  double upright_ratio() const;
  double residual_m() const;  // RMS; 0 without any.

  SurfaceAgreement& operator+=(const SurfaceAgreement& other);
};

// The distinctive parts of the submap's own map, and of the other.
struct DistinctiveSides {
  const DistinctiveMap *submap, *map;
};

// An even sample of the submap's points against all of `map`. `T_common_submap` and `T_common_map`
// place them in one frame in which `up` is a unit vector. A point lies on the map when it has a
// neighbour there whose normal is within 60 degrees, within `distance_m` along that normal, and
// within that or a voxel across. Thread safe.
SurfaceAgreement MeasureAgreement(const PreparedSubmap& submap, const Pose& T_common_submap,
                                  const PreparedSubmaps& map, const std::vector<Pose>& T_common_map,
                                  const Eigen::Vector3d& up, double distance_m,
                                  const std::optional<DistinctiveSides>& distinctive = {});

}  // namespace isthmus::matching
