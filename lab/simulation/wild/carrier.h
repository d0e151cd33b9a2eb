// The carrier that moves the sensor along a path, and shakes it.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "core/pose.h"
#include "lab/simulation/random.h"
#include "lab/simulation/route.h"
#include "lab/simulation/wild/path.h"

namespace isthmus::simulation::wild {

enum class Gait { kWheels, kLegs, kHand, kCar };

std::string NameOf(Gait gait);

// The sum of a few sines. Value type.
class Oscillation {
 public:
  Oscillation() = default;
  // Root of the mean square `rms`, frequencies from `low_hz` to `high_hz`.
  Oscillation(double rms, double low_hz, double high_hz, Random& random);
  double At(double seconds) const;

 private:
  struct Sine {
    double amplitude, per_s, phase;
  };
  std::vector<Sine> sines_;
};

// All of a carrier that is drawn before there is a path for it.
struct Carrier {
  Gait gait = Gait::kWheels;
  double speed_mps = 1;  // The highest.
  double acceleration_mps2 = 1, braking_mps2 = 1, lateral_mps2 = 1, yaw_rate_radps = 1;
  bool under_way = false;    // At its speed when the first scan begins.
  double stop_every_m = 50;  // On average.
  double base_m = 0.5;       // Between wheels or feet.
  double height_m = 0.8;     // The sensor's.
  Pose T_base_sensor;        // Base: on the ground, x ahead.

  // The gait is one of `gaits`, the speed not above `top_mps`.
  static Carrier Draw(const std::vector<Gait>& gaits, double top_mps, Random& random);
};

// Distance along a path by time. Jerk is bounded. Immutable.
class Timetable {
 public:
  // Goes from `begin_m` on, for `seconds`; or no farther than to `end_m`, where it stops. They are
  // 0.1 m apart or more.
  Timetable(const Path& path, const Carrier& carrier, double begin_m, double seconds,
            Random& random, double end_m = std::numeric_limits<double>::infinity());

  struct State {
    double s = 0, speed_mps = 0, acceleration_mps2 = 0;
  };
  State At(double seconds) const;
  struct Stop {
    double begin_s, end_s;
  };
  const std::vector<Stop>& stops() const { return stops_; }
  double end_s() const;  // From then on it stands.

 private:
  std::vector<double> s_;  // At even steps of time.
  std::vector<Stop> stops_;
};

// T_world_base of a carrier on a path, without shaking.
Pose BaseOn(const Path::Sample& at, const Carrier& carrier);

// T_world_base, without shaking, and T_world_sensor.
struct CarrierMotion {
  Motion base, sensor;
  // T_world_sensor of a base that is there then, and moves so.
  std::function<Pose(const Pose& T_world_base, const Timetable::State& state, double seconds)>
      shaken;
};
CarrierMotion CarrySensor(std::shared_ptr<const Path> path,
                          std::shared_ptr<const Timetable> timetable, const Carrier& carrier,
                          Random& random);

}  // namespace isthmus::simulation::wild
