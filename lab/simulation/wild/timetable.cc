#include <algorithm>
#include <cmath>

#include "lab/simulation/wild/carrier.h"

namespace isthmus::simulation::wild {
namespace {

constexpr double kAlong = 0.05;     // Metres between entries of the speeds.
constexpr double kTableStep = 0.1;  // Seconds between entries of the table.

// The speeds that are allowed every kAlong metres, with zeros where it stops, and if it `ends`
// at the last.
std::vector<double> Speeds(const Path& path, const Carrier& carrier, double begin_m, size_t count,
                           bool ends, Random& random) {
  // The driver's mind: slower stretches.
  const Oscillation mood(0.2, 0.005, 0.08, random);
  double next_stop = carrier.stop_every_m * random.Uniform(0.2, 1.5);
  std::vector<double> speeds;
  for (size_t i = 0; i < count; ++i) {
    const double s = static_cast<double>(i) * kAlong;
    double bend = 1e-9;
    for (const double offset : {-0.1, 0.0, 0.1}) {
      bend = std::max(bend, std::abs(path.At(begin_m + s + offset).curvature));
    }
    const double wanted = carrier.speed_mps * std::clamp(0.8 + mood.At(s), 0.3, 1.0);
    speeds.push_back(
        std::min({wanted, std::sqrt(carrier.lateral_mps2 / bend), carrier.yaw_rate_radps / bend}));
    if (s >= next_stop) {
      speeds.back() = 0;
      next_stop = s + carrier.stop_every_m * random.Uniform(0.2, 2);
    }
  }
  if (!carrier.under_way) speeds[0] = 0;
  if (ends) speeds.back() = 0;
  const auto limit = [&](size_t i, size_t from, double acceleration) {
    const double v = speeds[from];
    speeds[i] = std::min(speeds[i], std::sqrt(v * v + 2 * acceleration * kAlong));
  };
  for (size_t i = 1; i < count; ++i) limit(i, i - 1, carrier.acceleration_mps2);
  for (size_t i = count - 1; i-- > 0;) limit(i, i + 1, carrier.braking_mps2);
  return speeds;
}

}  // namespace

Timetable::Timetable(const Path& path, const Carrier& carrier, double begin_m, double seconds,
                     Random& random, double end_m) {
  auto count = static_cast<size_t>(carrier.speed_mps * (seconds + 2) / kAlong) + 3;
  const double to_end = (end_m - begin_m) / kAlong;
  const bool ends = to_end < static_cast<double>(count);
  if (ends) count = static_cast<size_t>(to_end) + 1;
  const auto speeds = Speeds(path, carrier, begin_m, count, ends, random);
  s_.push_back(begin_m);
  double now = 0;  // When entry i is reached.
  for (size_t i = 0; i + 1 < count && now < seconds + 2; ++i) {
    if (speeds[i] == 0) {
      const double wait = random.Uniform(0.3, 7);
      if (wait > 2) stops_.push_back({now + 0.3, now + wait - 0.3});
      now += wait;
    }
    const double then = now + 2 * kAlong / (speeds[i] + speeds[i + 1]);
    const double acceleration = (speeds[i + 1] - speeds[i]) / (then - now);
    while (static_cast<double>(s_.size()) * kTableStep < then) {
      const double dt = static_cast<double>(s_.size()) * kTableStep - now;
      const double since = dt < 0 ? 0 : speeds[i] * dt + acceleration * dt * dt / 2;
      s_.push_back(begin_m + static_cast<double>(i) * kAlong + since);
    }
    now = then;
  }
}

double Timetable::end_s() const { return kTableStep * static_cast<double>(s_.size() + 1); }

Timetable::State Timetable::At(double seconds) const {
  // A uniform cubic B-spline of the table: it smooths accelerations over a fifth of a second.
  const double u = std::max(seconds, 0.0) / kTableStep;
  const auto i = static_cast<int64_t>(u);
  const double t = u - static_cast<double>(i), r = 1 - t;
  const auto last = static_cast<int64_t>(s_.size()) - 1;
  const auto at = [&](int64_t k) {
    if (k < 0) return 2 * s_[0] - s_[1];
    return s_[std::min(k, last)];
  };
  const double a = at(i - 1), b = at(i), c = at(i + 1), d = at(i + 2);
  State state;
  state.s = (r * r * r * a + (3 * t * t * t - 6 * t * t + 4) * b +
             (-3 * t * t * t + 3 * t * t + 3 * t + 1) * c + t * t * t * d) /
            6;
  state.speed_mps =
      (-r * r * a + (3 * t * t - 4 * t) * b + (-3 * t * t + 2 * t + 1) * c + t * t * d) /
      (2 * kTableStep);
  state.acceleration_mps2 =
      (r * a + (3 * t - 2) * b + (1 - 3 * t) * c + t * d) / (kTableStep * kTableStep);
  return state;
}

}  // namespace isthmus::simulation::wild
