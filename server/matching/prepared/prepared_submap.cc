#include "server/matching/prepared/prepared_submap.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/geometry/near.h"
#include "server/matching/prepared/limits.h"
#include "server/matching/registration/limits.h"
#include "server/matching/registration/surface_sample.h"
#include "server/matching/search/wall_map.h"

namespace isthmus::matching {
namespace {

std::vector<Eigen::Vector3f> Sensors(const Submap& submap) {
  std::vector<Eigen::Vector3f> sensors;
  for (const Keyframe& keyframe : submap.keyframes) {
    sensors.push_back(keyframe.T_submap_sensor.translation().cast<float>());
  }
  return sensors;
}

// Selects keyframes that are `spacing` times the usual apart from the one taken before.
std::vector<bool> SpreadOut(const std::vector<Keyframe>& keyframes,
                            const std::vector<bool>& has_points, double spacing) {
  std::vector<bool> taken(keyframes.size(), false);
  const Pose* last = nullptr;
  for (size_t k = 0; k < keyframes.size(); ++k) {
    const Pose& pose = keyframes[k].T_submap_sensor;
    if (!has_points[k] ||
        (last != nullptr && AreNear(*last, pose, spacing * kViewSpacingM, spacing * kViewTurnRad)))
      continue;
    taken[k] = true;
    last = &pose;
  }
  return taken;
}

std::vector<bool> ChooseViews(const Submap& outline, const std::vector<SubmapPoint>& points) {
  std::vector<bool> has_points(outline.keyframes.size(), false);
  for (const SubmapPoint& point : points) {
    if (point.keyframe < has_points.size()) has_points[point.keyframe] = true;
  }
  std::vector<bool> taken = SpreadOut(outline.keyframes, has_points, 1);
  const auto count = [&] { return std::ranges::count(taken, true); };
  auto left = static_cast<std::ptrdiff_t>(kMaxViews);
  for (double spacing = 2; count() > left && spacing < 1e6; spacing *= 2) {
    taken = SpreadOut(outline.keyframes, has_points, spacing);
  }
  // Keyframes that jump to and fro by kilometres: the first ones.
  for (size_t k = 0; k < taken.size(); ++k) taken[k] = taken[k] && left-- > 0;
  return taken;
}

}  // namespace

PreparedSubmap::PreparedSubmap(std::shared_ptr<const Submap> outline, const Submap& whole,
                               const std::stop_token& stop)
    : submap_(std::move(outline)) {
  // Outdoors half as fine is enough, and a quarter of the cost; which it is shows at the coarse
  // one.
  voxel_m_ = kOutdoorVoxelM;
  surface_ = SampleSurface(whole, voxel_m_, stop);
  if (stop.stop_requested()) return;
  if (!IsOutdoors(surface_, Sensors(whole))) {
    voxel_m_ = kIndoorVoxelM;
    surface_ = SampleSurface(whole, voxel_m_, stop);
  }
  if (stop.stop_requested()) return;
  CollectViews(whole.points);
  IndexSurface();
}

PreparedSubmap::PreparedSubmap(std::shared_ptr<const Submap> submap, double voxel_m,
                               std::vector<SurfacePoint> surface, std::vector<View> views)
    : submap_(std::move(submap)),
      voxel_m_(voxel_m),
      surface_(std::move(surface)),
      views_(std::move(views)) {
  IndexSurface();
}

void PreparedSubmap::IndexSurface() {
  std::vector<Eigen::Vector3f> positions;
  positions.reserve(surface_.size());
  for (const SurfacePoint& point : surface_) positions.push_back(point.position);
  tree_ = KdTree(positions);
  sample_ = SampleBalanced(surface_, 2 * voxel_m_, kAlignedPoints);
  if (positions.empty()) return;
  Eigen::Vector3f low = positions.front(), high = positions.front();
  for (const Eigen::Vector3f& p : positions) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  const Eigen::Vector3f middle = 0.5f * (low + high);
  float radius2 = 0;
  for (const Eigen::Vector3f& p : positions)
    radius2 = std::max(radius2, (p - middle).squaredNorm());
  center_ = middle.cast<double>();
  radius_m_ = std::sqrt(static_cast<double>(radius2));
}

size_t PreparedSubmap::bytes() const {
  // A tree has a copy of its points and about as much again in nodes.
  size_t bytes = sizeof(PreparedSubmap) + surface_.capacity() * sizeof(SurfacePoint) +
                 surface_.size() * 2 * sizeof(Eigen::Vector3f) + sample_.capacity() * sizeof(int);
  for (const View& view : views_) {
    bytes += sizeof(View) + 2 * view.image.shortest_cm().size() * sizeof(uint16_t);
  }
  return bytes;
}

void PreparedSubmap::CollectViews(const std::vector<SubmapPoint>& submap_points) {
  std::vector<std::vector<Eigen::Vector3f>> points(submap_->keyframes.size());
  const std::vector<bool> taken = ChooseViews(*submap_, submap_points);
  for (const SubmapPoint& point : submap_points) {
    if (point.keyframe >= points.size() || !taken[point.keyframe]) continue;
    points[point.keyframe].push_back(point.Position());
  }
  for (size_t k = 0; k < points.size(); ++k) {
    if (!taken[k]) continue;
    const Pose& T_submap_sensor = submap_->keyframes[k].T_submap_sensor;
    const Pose T_sensor_submap = T_submap_sensor.Inverse();
    const Eigen::Matrix3f R = T_sensor_submap.RotationMatrix().cast<float>();
    const Eigen::Vector3f t = T_sensor_submap.translation().cast<float>();
    for (Eigen::Vector3f& p : points[k]) p = R * p + t;
    views_.push_back({T_submap_sensor, RangeImage(points[k])});
  }
}

bool Meet(const PreparedSubmap& a, const PreparedSubmap& b, const Pose& T_a_b, double reach_m) {
  const double apart = (a.center() - T_a_b * b.center()).norm();
  return apart < a.radius_m() + b.radius_m() + reach_m;
}

std::vector<SurfacePoint> JoinSurfaces(const PreparedSubmaps& submaps, size_t max_points,
                                       double* voxel_m) {
  std::vector<SurfacePart> parts;
  for (const auto& submap : submaps) {
    parts.push_back({&submap->surface(), submap->submap().T_odom_submap});
  }
  return JoinSurfaces(parts, max_points, voxel_m);
}

}  // namespace isthmus::matching
