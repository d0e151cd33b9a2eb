// The route of a simulated robot, and its motion along it.
#pragma once

#include <absl/status/statusor.h>

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <vector>

#include "core/pose.h"
#include "lab/simulation/worlds/world.h"

namespace isthmus::simulation {

// T_world_sensor at a time in seconds from the start of the simulation; defined for every time.
// Must be safe to call from many threads.
using Motion = std::function<Pose(double seconds)>;

// A closed curve in the plane with continuous curvature: the uniform cubic B-spline of a closed
// polygon's points, by arc length. Immutable.
class ClosedCurve {
 public:
  // At least 3 points, spaced about evenly.
  explicit ClosedCurve(std::vector<Eigen::Vector2d> control);

  struct Sample {
    Eigen::Vector2d position;
    double yaw = 0;        // The tangent's, in (-pi, pi].
    double curvature = 0;  // Signed, 1/m.
  };
  // `s` in metres; any value, the curve is closed.
  Sample At(double s) const;
  double length() const { return arc_.back(); }
  // Length from the start of the curve to where it passes control point `index`.
  double LengthTo(size_t index) const;

 private:
  void Evaluate(double u, Eigen::Vector2d& p, Eigen::Vector2d& d1, Eigen::Vector2d& d2) const;

  std::vector<Eigen::Vector2d> control_;
  std::vector<double> arc_;    // Length up to each of the evenly spaced parameters.
  std::vector<double> slope_;  // Derivative of the parameter by length there.
};

struct SpeedLimits {
  double speed_mps = 1.2;
  double acceleration_mps2 = 0.6;
  double lateral_mps2 = 0.8;
  double yaw_rate_radps = 0.8;
};

// Distance along a curve by time: starts at rest, is as fast as the limits allow, never stops.
// Velocity is continuous; limits hold to within 2 %. Immutable.
class SpeedProfile {
 public:
  // Long enough for `seconds`.
  SpeedProfile(const ClosedCurve& curve, const SpeedLimits& limits, double seconds);

  struct State {
    double s = 0;  // Metres.
    double speed_mps = 0;
  };
  State At(double seconds) const;
  // When `s` is reached; infinity if that is beyond the profile.
  double TimeAt(double s) const;

 private:
  std::vector<double> speed_;  // At every kStep metres.
  std::vector<double> time_;   // Ditto.
};

// One motion for each of `robots` (>= 1), around closed tours that start at rest and go on around
// for as long as needed. Tours are chosen so that in `seconds` every robot comes through places of
// its own and, where the world has them, through places that all robots share; about half of what a
// robot sees is seen by another. Deterministic by seed. Sensors nod and roll a little with the
// speed. InvalidArgument for robots < 1 or seconds <= 0.
absl::StatusOr<std::vector<Motion>> MakeRoutes(const World& world, int robots, double seconds,
                                               uint64_t seed);

// A closed tour that is driven again and again.
struct Lap {
  // From rest at 0. From `begin_s` on it repeats every `seconds`: pose and velocity are the same
  // (the velocity to within 2 %), so that the turns of one lap can stand for those of every other.
  Motion motion;
  double begin_s = 0;
  double seconds = 0;
};

// One of so many robots: as in MakeRoutes, they have places of their own and some that all share.
struct TeamMember {
  int robots = 1, robot = 0;
};

// A lap of the longest tour whose places all come in sight within `about_s`. Both times are whole
// multiples of `turn_s`, a sensor's period. The rest as MakeRoutes. InvalidArgument for times that
// are not positive and for a robot that is not one of `member.robots`.
absl::StatusOr<Lap> MakeLap(const World& world, double about_s, double turn_s, uint64_t seed,
                            const TeamMember& member = {});

// Motions of people: `count` motions of the point between their feet, around tours of their own for
// at least `seconds`, on the same stretches as the robots but farther to the sides. By the time a
// robot sets out they are on their way. Deterministic by seed.
std::vector<Motion> MakeWalks(const World& world, int count, double seconds, uint64_t seed);

// Motions of cars: `count` motions of the point on the road below their middle, x ahead, around
// tours of their own for at least `seconds`, 2.2 m to the right of the streets' middle (less in
// bends), each at a speed of its own of 3 to 8 m/s, slower in bends. They are on their way from the
// beginning. Deterministic by seed.
std::vector<Motion> MakeTraffic(const World& world, int count, double seconds, uint64_t seed);

// Motions of cars that stand 2.8 m to the right of the streets' middle (less in bends), `count` of
// them. Each is gone, deep below the ground, from a time of its own on: in the middle half of
// `seconds`. Deterministic by seed.
std::vector<Motion> MakeParked(const World& world, int count, double seconds, uint64_t seed);

}  // namespace isthmus::simulation
