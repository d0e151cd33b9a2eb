#include "floam/match/feature_map.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "floam/match/limits.h"
#include "floam/scan/undistort.h"

namespace isthmus::floam {
FeatureMap::FeatureMap(const OdometryOptions& options)
    : options_(options),
      surfaces_(ShapeKind::kPlane, options.map),
      edges_(ShapeKind::kLine, options.map),
      poles_(ShapeKind::kPole, options.map) {}

void FeatureMap::Insert(const Features& features, const ScanPose& pose, double period_s) {
  const ScanMotion motion(pose.twist, pose.reference_s, -period_s, 0);
  const Eigen::Matrix3d R = pose.T_odom_sensor.RotationMatrix();
  const Eigen::Vector3d& t = pose.T_odom_sensor.translation();
  const auto insert = [&](const std::vector<TimedPoint>& from, LocalMap* map) {
    for (const TimedPoint& p : from) {
      const Eigen::Vector3d q = R * motion.ToReference(p.position, p.time).cast<double>();
      map->Insert(q + t, features.in_rings ? p.ring : VoxelSums::kSeveral);
    }
  };
  insert(features.map_surfaces, &surfaces_);
  insert(features.edges, &edges_);
  insert(features.poles, &poles_);
  T_odom_inserted_ = pose.At(0);
  if (scans_ == 0) began_odom_ = T_odom_inserted_.translation();
  moved_m_ = std::max(moved_m_, (T_odom_inserted_.translation() - began_odom_).norm());
  ++scans_;
}

void FeatureMap::Update(const Features& features, const ScanPose& pose, double period_s) {
  const Pose T_odom_end = pose.At(0);
  const Pose moved = T_odom_inserted_.Inverse() * T_odom_end;
  if (!IsNew() && moved.translation().norm() < options_.map_distance_m &&
      RotationAngle(moved) < options_.map_angle_rad) {
    return;
  }
  Insert(features, pose, period_s);
  surfaces_.Evict(T_odom_end.translation());
  edges_.Evict(T_odom_end.translation());
  poles_.Evict(T_odom_end.translation());
}

void FeatureMap::Resume(const Cloud& map_odom, const Pose& T_odom_sensor) {
  for (const Point& p : map_odom) surfaces_.Insert(p.Position().cast<double>());
  T_odom_inserted_ = T_odom_sensor;
  scans_ = options_.map_first_scans;
  moved_m_ = options_.map_young_distance_m;
}

void FeatureMap::Clear() {
  surfaces_.Clear();
  edges_.Clear();
  poles_.Clear();
  scans_ = 0;
  moved_m_ = 0;
}

double FeatureMap::ScorePoints(const std::vector<Eigen::Vector3d>& points,
                               const Pose& T_odom_sensor, double kernel_m) {
  const Eigen::Matrix3d R = T_odom_sensor.RotationMatrix();
  const Eigen::Vector3d& t = T_odom_sensor.translation();
  const double kernel2 = kernel_m * kernel_m;
  double sum = 0;
  LocalMap::Found found;
  for (const Eigen::Vector3d& point : points) {
    const Eigen::Vector3d p = R * point + t;
    surfaces_.Find(p, &found);
    if (found.shape == nullptr || std::abs(found.shape->direction.z()) > kGroundNormalZ) continue;
    const Eigen::Vector3d offset = p - found.origin - found.shape->mean.cast<double>();
    const double distance = found.shape->direction.cast<double>().dot(offset);
    const double ratio = kernel2 / (kernel2 + distance * distance);
    sum += ratio * ratio;
  }
  return sum;
}

}  // namespace isthmus::floam
