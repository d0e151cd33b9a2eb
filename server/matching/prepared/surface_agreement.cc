#include "server/matching/prepared/surface_agreement.h"

#include <algorithm>
#include <cmath>

#include "server/matching/prepared/limits.h"
#include "server/matching/registration/limits.h"

namespace isthmus::matching {
namespace {

Eigen::Vector3f InOdom(const PreparedSubmap& submap, const SurfacePoint& point) {
  return (submap.submap().T_odom_submap * point.position.cast<double>()).cast<float>();
}

double Share(double part, double whole) { return whole > 0 ? part / whole : 0; }

}  // namespace

double SurfaceAgreement::overlap() const {
  return Share(static_cast<double>(on), static_cast<double>(asked));
}

double SurfaceAgreement::ratio() const {
  return Share(static_cast<double>(on), static_cast<double>(near));
}

double SurfaceAgreement::upright_ratio() const {
  return Share(static_cast<double>(on_upright), static_cast<double>(near_upright));
}

double SurfaceAgreement::residual_m() const {
  return std::sqrt(Share(squared_m2, static_cast<double>(on)));
}

SurfaceAgreement& SurfaceAgreement::operator+=(const SurfaceAgreement& other) {
  asked += other.asked;
  near += other.near;
  on += other.on;
  squared_m2 += other.squared_m2;
  near_upright += other.near_upright;
  on_upright += other.on_upright;
  on_distinctive += other.on_distinctive;
  scatter += other.scatter;
  return *this;
}

SurfaceAgreement MeasureAgreement(const PreparedSubmap& submap, const Pose& T_common_submap,
                                  const PreparedSubmaps& map, const std::vector<Pose>& T_common_map,
                                  const Eigen::Vector3d& up, double distance_m,
                                  const std::optional<DistinctiveSides>& distinctive) {
  struct Target {
    const PreparedSubmap* submap;
    Eigen::Matrix3f R;  // To the target's frame.
    Eigen::Vector3f t;
    Eigen::Matrix3d R_common;  // From there to the common frame.
    float reach;
  };
  std::vector<Target> targets;
  for (size_t i = 0; i < map.size(); ++i) {
    const Pose T = T_common_map[i].Inverse() * T_common_submap;
    if (!Meet(*map[i], submap, T, kSeenM)) continue;
    targets.push_back({map[i].get(), T.RotationMatrix().cast<float>(),
                       T.translation().cast<float>(), T_common_map[i].RotationMatrix(),
                       static_cast<float>(std::max(distance_m, map[i]->voxel_m()))});
  }
  const Eigen::Vector3f up_submap = (T_common_submap.rotation().inverse() * up).cast<float>();
  SurfaceAgreement result;
  const std::vector<SurfacePoint>& points = submap.surface();
  const size_t stride = points.size() / kMaxAgreementPoints + 1;
  for (size_t k = 0; k < points.size(); k += stride) {
    ++result.asked;
    bool near = false, on = false;
    for (const Target& target : targets) {
      const Eigen::Vector3f p = target.R * points[k].position + target.t;
      const Eigen::Vector3f n = target.R * points[k].normal;
      const std::vector<SurfacePoint>& surface = target.submap->surface();
      const auto neighbor = target.submap->tree().NearestIf(
          p, target.reach, [&](int j) { return surface[j].normal.dot(n) > kMinNormalCosine; });
      if (neighbor.index < 0) {
        near = near || target.submap->tree().Nearest(p, kSeenM).index >= 0;
        continue;
      }
      near = true;
      const SurfacePoint& q = surface[neighbor.index];
      const double off = q.normal.dot(q.position - p);
      if (std::abs(off) > distance_m) continue;
      on = true;
      if (distinctive) {
        result.on_distinctive += distinctive->submap->Has(InOdom(submap, points[k])) &&
                                 distinctive->map->Has(InOdom(*target.submap, q));
      }
      result.squared_m2 += off * off;
      Eigen::Matrix<double, 3, 6> J;
      J.leftCols<3>().setIdentity();
      J.rightCols<3>() = -Skew(T_common_submap * points[k].position.cast<double>());
      const Eigen::Matrix<double, 1, 6> row =
          (target.R_common * q.normal.cast<double>()).transpose() * J;
      result.scatter.noalias() += row.transpose() * row;
      break;
    }
    const bool upright = std::abs(points[k].normal.dot(up_submap)) < kMaxUprightNormalZ;
    result.near += near;
    result.on += on;
    result.near_upright += near && upright;
    result.on_upright += on && upright;
  }
  return result;
}

}  // namespace isthmus::matching
