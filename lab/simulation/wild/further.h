// A ride that goes on after it has ended, or elsewhere from some time on.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "lab/simulation/random.h"
#include "lab/simulation/route.h"
#include "lab/simulation/sensors/ray_caster.h"
#include "lab/simulation/wild/carrier.h"

namespace isthmus::simulation {

// A change of a drive after so many scans, up to which it is as without it.
struct Further {
  int after_scans = 0;
  // It follows these points, as seen from above, and stands at the last; see GoOn.
  std::vector<Eigen::Vector3d> way = {};
  double along_m = 0;  // Without a way: so far along its own, see ToAndFro.
};

}  // namespace isthmus::simulation

namespace isthmus::simulation::wild {

// A scan ends at its time or a rounding later: so long after its change a motion is as before.
inline constexpr double kTickS = 1e-6;

// A motion that was made longer.
struct LongerMotion {
  Motion base;           // T_world_base.
  double end_s = 0;      // From then on it stands.
  double metres = 0;     // Way that was added, from above.
  bool blocked = false;  // Something solid is in the way: it stands half a metre before it.
};

// As `base` until `from_s`; then it brakes, turns on the spot, follows the points as they are seen
// from above, at the carrier's speed, and stands at the last. It never turns faster than 0.8 rad/s.
// It may come to rest on the way, and goes on from there then; corners are rounded to within 0.2 m.
// `world` has the ground, and what is solid in it.
LongerMotion GoOn(const Motion& base, double from_s, std::vector<Eigen::Vector3d> way,
                  const Carrier& carrier, const RayCaster& world, Random& random);

// `metres` on along a path from `begin_m`, and back from 3 m before its end, and so on: what a
// carrier does that has nowhere to go.
std::vector<Eigen::Vector3d> ToAndFro(const Path& path, double begin_m, double metres);

// The time that GoOn brakes for; where it comes to rest, `base` is after half of it.
double BrakingSeconds(const Motion& base, double from_s);

// Speed and acceleration of a base.
Timetable::State StateOf(const Motion& base, double seconds);

}  // namespace isthmus::simulation::wild
