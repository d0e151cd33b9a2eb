// Submaps of random points, and what a map of them must hold.
#pragma once

#include <algorithm>
#include <memory>
#include <random>
#include <string>
#include <tuple>
#include <vector>

#include "core/composed_map.h"

namespace isthmus::composition {

inline PlacedSubmap MakeSubmap(const std::string& robot, uint32_t index,
                               std::vector<SubmapPoint> points, const Pose& T_map_submap = Pose(),
                               uint32_t component = 0) {
  auto submap = std::make_shared<Submap>();
  submap->id = {SessionId(robot + "-1"), index};
  submap->robot = RobotId(robot);
  submap->keyframes.resize(1);
  submap->points = std::move(points);
  return {submap, component, T_map_submap};
}

inline SubmapPoint At(double x, double y, double z, double intensity = 0) {
  return {static_cast<float>(x), static_cast<float>(y), static_cast<float>(z),
          static_cast<float>(intensity), 0};
}

// Uniform in the box.
inline std::vector<SubmapPoint> RandomPoints(std::mt19937* rng, int count, const Box& box) {
  std::uniform_real_distribution<double> unit(0, 1);
  std::vector<SubmapPoint> points;
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector3d share(unit(*rng), unit(*rng), unit(*rng));
    const Eigen::Vector3d p = box.min + share.cwiseProduct(box.max - box.min);
    points.push_back(At(p.x(), p.y(), p.z(), unit(*rng)));
  }
  return points;
}

inline Box MakeBox(const Eigen::Vector3d& min, const Eigen::Vector3d& max) {
  Box box;
  box.Extend(min);
  box.Extend(max);
  return box;
}

inline std::vector<MapPoint> ReadAll(const ComposedMap& map, const Region& region = {},
                                     size_t chunk = 1000) {
  std::vector<MapPoint> all;
  map.Read(region, chunk, [&](const std::vector<MapPoint>& points) {
    all.insert(all.end(), points.begin(), points.end());
    return true;
  });
  return all;
}

// In an order of their own, to compare as sets.
inline std::vector<std::tuple<float, float, float, float, uint32_t>> Sorted(
    const std::vector<MapPoint>& points) {
  std::vector<std::tuple<float, float, float, float, uint32_t>> sorted;
  for (const MapPoint& p : points) sorted.emplace_back(p.x, p.y, p.z, p.intensity, p.robot);
  std::sort(sorted.begin(), sorted.end());
  return sorted;
}

}  // namespace isthmus::composition
