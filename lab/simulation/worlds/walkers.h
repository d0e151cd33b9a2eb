// People among the robots.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "lab/simulation/route.h"
#include "lab/simulation/sensors/ray_caster.h"

namespace isthmus::simulation {

// Upright cylinders, 1.75 m tall and half a metre wide, during one turn of a sensor, in which they
// walk in a straight line. Thread safe.
class Walkers {
 public:
  Walkers(const std::vector<Motion>& walks, double begin_s, double end_s);

  // Makes `hit` the nearest walker's, as of `fraction` of the turn, if one stands before it. Rays
  // that start inside a walker pass through it.
  void Occlude(const Ray& ray, double fraction, float max_range_m, Hit& hit) const;

 private:
  struct Leg {
    Eigen::Vector3f from, to;  // Between the feet.
  };
  std::vector<Leg> legs_;
};

}  // namespace isthmus::simulation
