#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/geometry/angles.h"
#include "lab/simulation/wild/carrier.h"

namespace isthmus::simulation::wild {
namespace {

// The shaking of a carrier: along x, y, z and about them.
struct Shaking {
  Oscillation moved[3], turned[3];
  double at_rest = 0;  // Share of it that is there at rest.
  // Vibration of an engine or of wheels on gravel.
  Oscillation rattle[6];
};

Shaking Shakes(const Carrier& carrier, Random& random) {
  Shaking shaking;
  double sway_m = 0, sway_deg = 0, low_hz = 0.3, high_hz = 2, bob_m = 0, step_hz = 0;
  const double strength = random.Chance(0.3) ? random.Uniform(0, 0.3) : random.Uniform(0.3, 1);
  switch (carrier.gait) {
    case Gait::kWheels:
      sway_m = 0.01, sway_deg = 1.2, high_hz = 3;
      break;
    case Gait::kCar:
      sway_m = 0.02, sway_deg = 1, high_hz = 2;
      break;
    case Gait::kLegs:
      sway_m = 0.015, sway_deg = 2.5, low_hz = 1, high_hz = 2.5, bob_m = 0.01, step_hz = 2.5;
      break;
    case Gait::kHand:
      sway_m = 0.06, sway_deg = 9, low_hz = 0.15, high_hz = 1, bob_m = 0.03, step_hz = 1.9;
      shaking.at_rest = random.Uniform(0.1, 0.6);
      break;
  }
  for (int axis = 0; axis < 3; ++axis) {
    const double upright = axis == 2 ? 0.5 : 1;
    shaking.moved[axis] = axis == 2 && bob_m > 0
                              ? Oscillation(strength * bob_m, 0.9 * step_hz, 1.1 * step_hz, random)
                              : Oscillation(strength * upright * sway_m, low_hz, high_hz, random);
    shaking.turned[axis] = Oscillation(strength * sway_deg * kRadPerDeg * random.Uniform(0.5, 1),
                                       low_hz, high_hz, random);
  }
  const double rattle = random.Chance(0.5) ? 0 : random.Unit();
  const bool wheels = carrier.gait == Gait::kWheels || carrier.gait == Gait::kCar;
  for (int i = 0; i < 6; ++i) {
    const double rms = i < 3 ? 0.0003 : 0.06 * kRadPerDeg;
    shaking.rattle[i] = Oscillation(wheels ? rattle * rms : 0.2 * rattle * rms, 6, 25, random);
  }
  return shaking;
}

// Turns on the spot and back while standing.
struct Look {
  double begin_s, end_s, by_rad;

  double At(double t) const {
    if (t <= begin_s || t >= end_s) return 0;
    const double s = std::sin(std::numbers::pi * (t - begin_s) / (end_s - begin_s));
    return by_rad * s * s;
  }
};

std::vector<Look> Looks(const Timetable& timetable, const Carrier& carrier, Random& random) {
  std::vector<Look> looks;
  if (carrier.gait == Gait::kCar) return looks;
  for (const Timetable::Stop& stop : timetable.stops()) {
    const double by = random.Uniform(-1, 1) * std::numbers::pi;
    if (random.Chance(0.5)) continue;
    // Turning by sin^2 is fastest at pi * by / time.
    const double allowed = carrier.yaw_rate_radps * (stop.end_s - stop.begin_s) / std::numbers::pi;
    looks.push_back({stop.begin_s, stop.end_s, std::clamp(by, -allowed, allowed)});
  }
  return looks;
}

}  // namespace

Oscillation::Oscillation(double rms, double low_hz, double high_hz, Random& random) {
  constexpr int kSines = 3;
  for (int i = 0; i < kSines; ++i) {
    const double hz = low_hz * std::pow(high_hz / low_hz, random.Unit());
    sines_.push_back({rms * std::sqrt(2.0 / kSines), 2 * std::numbers::pi * hz,
                      random.Uniform(0, 2 * std::numbers::pi)});
  }
  if (rms <= 0) sines_.clear();
}

double Oscillation::At(double seconds) const {
  double value = 0;
  for (const Sine& sine : sines_) {
    value += sine.amplitude * std::sin(sine.per_s * seconds + sine.phase);
  }
  return value;
}

Pose BaseOn(const Path::Sample& at, const Carrier& carrier) {
  // People stay upright on a slope.
  const double lean = carrier.gait == Gait::kHand ? 0.1 : 1;
  return Pose::FromXyzRpy(at.position.x(), at.position.y(), at.position.z(), lean * at.roll,
                          lean * at.pitch, at.yaw);
}

CarrierMotion CarrySensor(std::shared_ptr<const Path> path,
                          std::shared_ptr<const Timetable> timetable, const Carrier& carrier,
                          Random& random) {
  const Shaking shaking = Shakes(carrier, random);
  const auto looks = Looks(*timetable, carrier, random);
  const bool is_car = carrier.gait == Gait::kCar;
  const double nod = carrier.gait == Gait::kHand ? 0 : random.Uniform(0, is_car ? 0.015 : 0.03);
  CarrierMotion carrier_motion;
  carrier_motion.base = [path, timetable, looks, carrier](double t) {
    Path::Sample at = path->At(timetable->At(t).s);
    for (const Look& look : looks) at.yaw += look.At(t);
    return BaseOn(at, carrier);
  };
  carrier_motion.shaken = [=, top = carrier.speed_mps, mounting = carrier.T_base_sensor](
                              const Pose& T_world_base, const Timetable::State& state, double t) {
    const double pace = state.speed_mps / (state.speed_mps + 0.2 * top + 1e-3);
    const double sway = shaking.at_rest + (1 - shaking.at_rest) * pace;
    double by[6];
    for (int i = 0; i < 6; ++i) {
      by[i] = sway * (i < 3 ? shaking.moved[i].At(t) : shaking.turned[i - 3].At(t)) +
              pace * shaking.rattle[i].At(t);
    }
    // Braking lowers the nose.
    by[4] -= nod * state.acceleration_mps2;
    return T_world_base * Pose::FromXyzRpy(by[0], by[1], by[2], by[3], by[4], by[5]) * mounting;
  };
  carrier_motion.sensor = [base = carrier_motion.base, shaken = carrier_motion.shaken,
                           timetable](double t) { return shaken(base(t), timetable->At(t), t); };
  return carrier_motion;
}

}  // namespace isthmus::simulation::wild
