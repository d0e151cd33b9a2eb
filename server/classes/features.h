// The numbers by which a forest tells what a point is of.
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <span>
#include <vector>

#include "server/classes/columns.h"
#include "server/classes/ground_grid.h"
#include "server/classes/limits.h"
#include "server/classes/moments.h"

namespace isthmus::classes {

inline constexpr int kFeatures = kLevels * 7 + 17;  // Layout
using Features = std::array<float, kFeatures>;

// The surroundings of a cloud's points. Not thread safe.
class Surroundings {
 public:
  // One frame; `up` in it. `sensors`: places from which the points were seen.
  Surroundings(std::span<const Eigen::Vector3f> points, std::span<const Eigen::Vector3f> sensors,
               const Eigen::Vector3f& up);

  size_t size() const { return level_.size(); }
  // The i-th point's. Always finite.
  Features Of(size_t i);
  // The i-th point above the ground, metres.
  float HeightOf(size_t i) const;

 private:
  Surroundings(std::span<const Eigen::Vector3f> points, std::span<const Eigen::Vector3f> sensors,
               const Eigen::Quaternionf& level);

  std::vector<Eigen::Vector3f> level_;  // The points, z up.
  Moments moments_;
  GroundGrid ground_;
  Columns columns_;
};

}  // namespace isthmus::classes
