#include "server/matching/search/wall_map.h"

#include <algorithm>
#include <cmath>

#include "server/matching/search/gravity.h"
#include "server/matching/search/limits.h"

namespace isthmus::matching {

bool IsOutdoors(const std::vector<SurfacePoint>& surface,
                const std::vector<Eigen::Vector3f>& sensors) {
  size_t floors = 0, ceilings = 0;
  for (const SurfacePoint& point : surface) {
    floors += point.normal.z() > kMinLevelNormalZ;
    ceilings += point.normal.z() < -kMinLevelNormalZ;
  }
  if (static_cast<double>(ceilings) > kMaxCeilingShare * static_cast<double>(floors)) return false;
  size_t asked = 0, far = 0;
  for (size_t i = 0; i < surface.size(); i += 20, ++asked) {
    const bool near = std::any_of(sensors.begin(), sensors.end(), [&](const auto& sensor) {
      return (sensor - surface[i].position).squaredNorm() < kFarM * kFarM;
    });
    far += !near;
  }
  return static_cast<double>(far) > kMinFarShare * static_cast<double>(asked);
}

void AddSensorPositions(const Submap& submap, std::vector<Eigen::Vector3f>* sensors) {
  for (const Keyframe& keyframe : submap.keyframes) {
    const Eigen::Vector3d& sensor = keyframe.T_submap_sensor.translation();
    sensors->push_back((submap.T_odom_submap * sensor).cast<float>());
  }
}

std::vector<Eigen::Vector3f> SensorPositions(const SessionMap& map) {
  std::vector<Eigen::Vector3f> sensors;
  for (const auto& submap : map.submaps) AddSensorPositions(*submap, &sensors);
  return sensors;
}

WallMap::WallMap(const SessionMap& map, const std::vector<SurfacePoint>& surface)
    : WallMap(map, surface, Pose(EstimateLevel(surface), Eigen::Vector3d::Zero())) {}

WallMap::WallMap(const SessionMap& map, const std::vector<SurfacePoint>& surface,
                 const Pose& T_level_odom)
    : T_level_odom_(T_level_odom) {
  const Eigen::Matrix3f R = T_level_odom_.RotationMatrix().cast<float>();
  std::vector<SurfacePoint> level = surface;
  for (SurfacePoint& point : level) {
    point.position = R * point.position;
    point.normal = R * point.normal;
  }
  ground_ = GroundGrid(level, kGroundCellM);
  for (const SurfacePoint& point : level) {
    if (std::abs(point.normal.z()) > kMaxWallNormalZ) continue;
    walls_.push_back({point.position, point.normal.head<2>().normalized(),
                      point.position.z() - ground_.Height(point.position.x(), point.position.y())});
  }
  CollectKeyframes(map);
  outdoors_ = IsOutdoors(level, sensors_);
  if (!outdoors_) FindStoreys(level);
}

Eigen::Vector3d WallMap::MeanSensor() const {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3f& sensor : sensors_) sum += sensor.cast<double>();
  if (!sensors_.empty()) sum /= static_cast<double>(sensors_.size());
  return T_level_odom_.Inverse() * sum;
}

void WallMap::FindStoreys(const std::vector<SurfacePoint>& level) {
  std::vector<size_t> floors(kStoreyBins, 0);  // By height above the lowest.
  size_t all = 0;
  for (const SurfacePoint& point : level) {
    if (point.normal.z() < kMinLevelNormalZ) continue;
    const Eigen::Vector3f& p = point.position;
    const auto bin =
        static_cast<int>(std::lround((p.z() - ground_.Height(p.x(), p.y())) / kStructureLayerM));
    if (bin < 0 || bin >= kStoreyBins) continue;
    ++floors[bin];
    ++all;
  }
  const auto least = static_cast<size_t>(kMinStoreyShare * static_cast<double>(all)) + 1;
  for (int bin = 1; bin + 1 < kStoreyBins; ++bin) {
    // A floor may lie on the edge of two bins.
    const size_t here = floors[bin] + std::max(floors[bin - 1], floors[bin + 1]);
    const float height = kStructureLayerM * static_cast<float>(bin);
    const bool is_peak = floors[bin] >= floors[bin - 1] && floors[bin] > floors[bin + 1];
    if (is_peak && here >= least && height - storeys_.back() >= kMinStoreyM) {
      storeys_.push_back(height);
    }
  }
}

void WallMap::CollectKeyframes(const SessionMap& map) {
  for (size_t s = 0; s < map.submaps.size(); ++s) {
    const std::shared_ptr<const Submap> submap = map.Whole(s);
    const Pose T_level_submap = T_level_odom_ * submap->T_odom_submap;
    const Eigen::Matrix3f R = T_level_submap.RotationMatrix().cast<float>();
    std::vector<int> slot(submap->keyframes.size(), -1);
    for (size_t k = 0; k < submap->keyframes.size(); ++k) {
      const Eigen::Vector3f sensor =
          (T_level_submap * submap->keyframes[k].T_submap_sensor.translation()).cast<float>();
      sensors_.push_back(sensor);
      const bool spaced =
          keyframes_.empty() || (keyframes_.back().sensor - sensor).norm() > kRaySpacingM;
      if (!spaced) continue;
      slot[k] = static_cast<int>(keyframes_.size());
      keyframes_.push_back({sensor, {}});
    }
    const Eigen::Vector3f t = T_level_submap.translation().cast<float>();
    // Every other point is plenty for a bin, and half of the memory.
    for (size_t i = 0; i < submap->points.size(); i += 2) {
      const SubmapPoint& point = submap->points[i];
      if (point.keyframe >= slot.size() || slot[point.keyframe] < 0) continue;
      KeyframeEnds& keyframe = keyframes_[slot[point.keyframe]];
      keyframe.ends.push_back(R * point.Position() + t - keyframe.sensor);
    }
  }
}

void WallMap::VisitEnds(const Visitor& visit) const {
  for (const KeyframeEnds& keyframe : keyframes_) {
    for (const Eigen::Vector3f& end : keyframe.ends) {
      const Eigen::Vector3f p = keyframe.sensor + end;
      visit(p.head<2>(), p.z() - ground_.Height(p.x(), p.y()), end.head<2>().norm());
    }
  }
}

const std::vector<FreeRay>& WallMap::FreeRays(const SceneScale& scale) const {
  MutexLock lock(&kept_rays_->mutex);
  const auto [rays, is_new] =
      kept_rays_->by_scale.try_emplace({scale.free.low, scale.free.high, scale.max_range_m});
  if (is_new) rays->second = MakeFreeRays(scale);
  return rays->second;
}

std::vector<FreeRay> WallMap::MakeFreeRays(const SceneScale& scale) const {
  std::vector<FreeRay> rays;
  std::vector<std::vector<std::pair<float, float>>> bins(kAzimuthBins);  // Range, height.
  for (const KeyframeEnds& keyframe : keyframes_) {
    const Eigen::Vector2f sensor = keyframe.sensor.head<2>();
    const float eye = keyframe.sensor.z() - ground_.Height(sensor.x(), sensor.y());
    for (auto& bin : bins) bin.clear();
    for (const Eigen::Vector3f& end : keyframe.ends) {
      const float range = end.head<2>().norm(), height = eye + end.z();
      if (!(range > 0.5f) || height < scale.free.low || height > scale.free.high) continue;
      const float turn = std::atan2(end.y(), end.x()) / (2 * static_cast<float>(M_PI)) + 0.5f;
      bins[std::min(static_cast<int>(turn * kAzimuthBins), kAzimuthBins - 1)].push_back(
          {range, height});
    }
    for (int i = 0; i < kAzimuthBins; ++i) {
      auto& bin = bins[i];
      if (bin.empty()) continue;
      // The median: half of the ranges say that it is free so far.
      const auto middle = bin.begin() + static_cast<std::ptrdiff_t>((bin.size() - 1) / 2);
      std::nth_element(bin.begin(), middle, bin.end());
      const auto [range, height] = *middle;
      // The part of the ray that is inside the band; its end is.
      float start = 0;
      if (eye < scale.free.low) start = (scale.free.low - eye) / std::max(height - eye, 1e-3f);
      if (eye > scale.free.high) start = (eye - scale.free.high) / std::max(eye - height, 1e-3f);
      const float azimuth =
          (2 * (static_cast<float>(i) + 0.5f) / kAzimuthBins - 1) * static_cast<float>(M_PI);
      const Eigen::Vector2f direction(std::cos(azimuth), std::sin(azimuth));
      const float stop = std::min(range, scale.max_range_m);
      if (start * range >= stop) continue;
      rays.push_back({sensor + start * range * direction, sensor + stop * direction});
    }
  }
  return rays;
}

}  // namespace isthmus::matching
