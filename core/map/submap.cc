#include "core/map/submap.h"

#include <algorithm>
#include <bit>

#include "core/content_hash.h"

namespace isthmus {
namespace {

uint64_t Pair(float a, float b) {
  return uint64_t{std::bit_cast<uint32_t>(a)} << 32 | std::bit_cast<uint32_t>(b);
}

}  // namespace

SubmapInfo Summarize(const Submap& submap) {
  SubmapInfo info;
  info.id = submap.id;
  info.robot = submap.robot;
  info.T_odom_submap = submap.T_odom_submap;
  info.drift_covariance = submap.drift_covariance;
  info.first_sequence = submap.first_sequence;
  info.last_sequence = submap.last_sequence;
  info.first_stamp_ns = submap.first_stamp_ns;
  info.last_stamp_ns = submap.last_stamp_ns;
  info.keyframe_count = static_cast<uint32_t>(submap.keyframes.size());
  info.point_count = submap.points.size();
  for (const SubmapPoint& p : submap.points) info.bounds.Extend(p.Position().cast<double>());
  info.content = ContentOf(submap);
  return info;
}

uint64_t ContentOf(const Submap& submap) {
  ContentHash hash;
  for (const Keyframe& keyframe : submap.keyframes) {
    hash.Add(keyframe.sequence);
    hash.Add(static_cast<uint64_t>(keyframe.stamp_ns));
    const Eigen::Vector4d rotation = keyframe.T_submap_sensor.rotation().coeffs();
    const Eigen::Vector3d translation = keyframe.T_submap_sensor.translation();
    for (const double value : rotation) hash.Add(std::bit_cast<uint64_t>(value));
    for (const double value : translation) hash.Add(std::bit_cast<uint64_t>(value));
  }
  for (const SubmapPoint& point : submap.points) {
    hash.Add(Pair(point.x, point.y));
    hash.Add(Pair(point.z, point.intensity));
    hash.Add(point.keyframe);
  }
  return std::max<uint64_t>(hash.value(), 1);
}

std::shared_ptr<const Submap> SessionMap::Whole(size_t k) const {
  if (!points) return submaps[k];
  std::shared_ptr<const Submap> whole = points(submaps[k]->id);
  if (!whole) return submaps[k];
  const Pose& T_odom_submap = submaps[k]->T_odom_submap;
  if (whole->T_odom_submap.Matrix() == T_odom_submap.Matrix()) return whole;
  auto moved = std::make_shared<Submap>(*whole);
  moved->T_odom_submap = T_odom_submap;
  return moved;
}

Box Transform(const Pose& T_target_source, const Box& box) {
  Box result;
  if (box.empty()) return result;
  for (int corner = 0; corner < 8; ++corner) {
    const Eigen::Vector3d p((corner & 1) ? box.max.x() : box.min.x(),
                            (corner & 2) ? box.max.y() : box.min.y(),
                            (corner & 4) ? box.max.z() : box.min.z());
    result.Extend(T_target_source * p);
  }
  return result;
}

}  // namespace isthmus
