// Cars that drive among the robots.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "lab/simulation/route.h"
#include "lab/simulation/sensors/ray_caster.h"

namespace isthmus::simulation {

// A body 4.4 m long, 1.8 m wide and up to 0.85 m high, 0.25 m above the road, and a cabin half as
// long on it, 1.45 m high in all; during one turn of a sensor, in which they drive in a straight
// line and turn evenly. Thread safe.
class Cars {
 public:
  // `drives` are motions of the point on the road below the middle, x ahead.
  Cars(const std::vector<Motion>& drives, double begin_s, double end_s);

  // Makes `hit` the nearest car's, as of `fraction` of the turn, if one is before it. Rays that
  // start inside a box pass through it.
  void Occlude(const Ray& ray, double fraction, float max_range_m, Hit& hit) const;

 private:
  struct Leg {
    Eigen::Vector3f from, to;
    float yaw_from = 0, yaw_by = 0;
  };
  std::vector<Leg> legs_;
};

}  // namespace isthmus::simulation
