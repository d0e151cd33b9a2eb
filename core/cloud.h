// Plain point clouds that stages exchange. Coordinates are float metres in a frame the owner names.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <vector>

#include "core/map/point_class.h"

namespace isthmus {

struct Point {
  float x = 0, y = 0, z = 0;
  float intensity = 0;

  Eigen::Vector3f Position() const { return {x, y, z}; }
};

using Cloud = std::vector<Point>;

// A point of the merged map. `robot` indexes the list of robots of the answer it came with.
struct MapPoint {
  float x = 0, y = 0, z = 0;
  float intensity = 0;
  uint32_t robot = 0;
  PointClass label = PointClass::kUnknown;
  // When its voxel was last seen: the end of the newest submap that saw it. Unix seconds; 0 where
  // it is not known.
  uint32_t stamp = 0;
};

// A point of the map as files and messages have it: x y z intensity (float32), robot and label
// (uint32), which is how it begins in memory.
inline constexpr size_t kMapRecordBytes = offsetof(MapPoint, stamp);
static_assert(kMapRecordBytes == 24 && offsetof(MapPoint, label) == 20);

// `out` has room for so many records.
inline void CopyMapRecords(const std::vector<MapPoint>& points, void* out) {
  auto* to = static_cast<char*>(out);
  for (const MapPoint& point : points) {
    std::memcpy(to, &point, kMapRecordBytes);
    to += kMapRecordBytes;
  }
}

// Axis-aligned box; empty (min > max) until the first Extend.
struct Box {
  Eigen::Vector3d min = Eigen::Vector3d::Constant(std::numeric_limits<double>::infinity());
  Eigen::Vector3d max = Eigen::Vector3d::Constant(-std::numeric_limits<double>::infinity());

  bool empty() const { return (min.array() > max.array()).any(); }
  void Extend(const Eigen::Vector3d& p) {
    min = min.cwiseMin(p);
    max = max.cwiseMax(p);
  }
  void Extend(const Box& other) {
    min = min.cwiseMin(other.min);
    max = max.cwiseMax(other.max);
  }
  // By so much on every side.
  Box Grown(double by_m) const {
    Box grown = *this;
    grown.min.array() -= by_m;
    grown.max.array() += by_m;
    return grown;
  }
  bool Contains(const Eigen::Vector3d& p) const {
    return (p.array() >= min.array()).all() && (p.array() <= max.array()).all();
  }
  bool Intersects(const Box& other) const {
    return (min.array() <= other.max.array()).all() && (other.min.array() <= max.array()).all();
  }
};

}  // namespace isthmus
