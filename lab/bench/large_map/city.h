// A city that robots drive through, as far as their LiDARs see it: streets between blocks of
// houses. For maps of any size at the cost of drawing their points.
#pragma once

#include <cstdint>
#include <memory>
#include <random>

#include "core/map/submap.h"
#include "core/pose.h"

namespace isthmus::bench {

struct CityOptions {
  int streets = 12;     // In x, one above the other; crossed by as many in y.
  double block_m = 60;  // From street to street.
  double street_width_m = 18;
  int keyframes = 15;   // Per submap, 1 m apart.
  int points = 66'000;  // Per keyframe: 64 lasers, about 1000 directions.
  double range_m = 80;
  double noise_m = 0.02;
};

class City {
 public:
  explicit City(const CityOptions& options) : options_(options) {}

  // The pose of a robot after so many metres of a path that leads through one street of x after the
  // other, to and fro, and starts over at the end. Its lane is off the middle of the street.
  Pose PoseAfter(double path_length_m, double lane_m) const;
  // The submap of what it sees from there on; points as measured, in the frame of the first
  // keyframe.
  Submap Drive(double path_length_m, double lane_m, std::mt19937* rng) const;
  double submap_length_m() const { return options_.keyframes * 1.0; }
  double path_length_m() const { return options_.streets * Edge(); }

 private:
  double Edge() const { return options_.streets * options_.block_m; }
  // The length of a ray from there; the range if it meets nothing.
  double Cast(const Eigen::Vector3d& from, const Eigen::Vector3d& direction) const;
  double HouseHeight(int x, int y) const;

  const CityOptions options_;
};

}  // namespace isthmus::bench
