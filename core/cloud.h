// Plain point clouds that stages exchange. Coordinates are float metres in a frame the owner names.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <limits>
#include <vector>

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
  uint32_t stamp = 0;  // When it was seen last: Unix seconds of the newest submap; 0: not known.
};

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
  bool Contains(const Eigen::Vector3d& p) const {
    return (p.array() >= min.array()).all() && (p.array() <= max.array()).all();
  }
  bool Intersects(const Box& other) const {
    return (min.array() <= other.max.array()).all() && (other.min.array() <= max.array()).all();
  }
};

}  // namespace isthmus
