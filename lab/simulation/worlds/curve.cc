#include <algorithm>
#include <cmath>
#include <limits>

#include "lab/simulation/route.h"

namespace isthmus::simulation {
namespace {

constexpr int kPerSegment = 8;         // Entries of the arc length table per control point.
constexpr double kProfileStep = 0.05;  // Metres between entries of a speed profile.

}  // namespace

ClosedCurve::ClosedCurve(std::vector<Eigen::Vector2d> control) : control_(std::move(control)) {
  const size_t count = control_.size() * kPerSegment;
  arc_.push_back(0);
  Eigen::Vector2d p, d1, d2;
  for (size_t i = 0; i <= count; ++i) {
    const double u = static_cast<double>(i) / kPerSegment;
    Evaluate(u, p, d1, d2);
    slope_.push_back(1 / std::max(d1.norm(), 1e-9));
    if (i == count) break;
    // Simpson's rule; the integrand is smooth within a segment.
    const double h = 1.0 / kPerSegment, at_start = d1.norm();
    Evaluate(u + h / 2, p, d1, d2);
    const double at_middle = d1.norm();
    Evaluate(u + h, p, d1, d2);
    arc_.push_back(arc_.back() + h / 6 * (at_start + 4 * at_middle + d1.norm()));
  }
}

void ClosedCurve::Evaluate(double u, Eigen::Vector2d& p, Eigen::Vector2d& d1,
                           Eigen::Vector2d& d2) const {
  const auto count = static_cast<int64_t>(control_.size());
  const double whole = std::floor(u);
  const double t = u - whole, r = 1 - t;
  const auto first = static_cast<int64_t>(whole);
  const auto at = [&](int64_t i) -> const Eigen::Vector2d& {
    return control_[((first + i) % count + count) % count];
  };
  const Eigen::Vector2d &a = at(-1), &b = at(0), &c = at(1), &d = at(2);
  p = (r * r * r * a + (3 * t * t * t - 6 * t * t + 4) * b +
       (-3 * t * t * t + 3 * t * t + 3 * t + 1) * c + t * t * t * d) /
      6;
  d1 = (-r * r * a + (3 * t * t - 4 * t) * b + (-3 * t * t + 2 * t + 1) * c + t * t * d) / 2;
  d2 = r * a + (3 * t - 2) * b + (1 - 3 * t) * c + t * d;
}

double ClosedCurve::LengthTo(size_t index) const {
  return arc_[std::min(index * kPerSegment, arc_.size() - 1)];
}

ClosedCurve::Sample ClosedCurve::At(double s) const {
  s -= std::floor(s / length()) * length();
  const auto next = std::upper_bound(arc_.begin() + 1, arc_.end() - 1, s);
  const size_t i = static_cast<size_t>(next - arc_.begin()) - 1;
  // Hermite interpolation of the parameter keeps the speed along the curve continuous.
  const double h = arc_[i + 1] - arc_[i], f = (s - arc_[i]) / h, g = 1 - f;
  const double u0 = static_cast<double>(i) / kPerSegment, u1 = u0 + 1.0 / kPerSegment;
  const double u = g * g * (1 + 2 * f) * u0 + f * f * (3 - 2 * f) * u1 +
                   h * f * g * (g * slope_[i] - f * slope_[i + 1]);
  Sample sample;
  Eigen::Vector2d d1, d2;
  Evaluate(u, sample.position, d1, d2);
  sample.yaw = std::atan2(d1.y(), d1.x());
  const double speed = std::max(d1.norm(), 1e-9);
  sample.curvature = (d1.x() * d2.y() - d1.y() * d2.x()) / (speed * speed * speed);
  return sample;
}

SpeedProfile::SpeedProfile(const ClosedCurve& curve, const SpeedLimits& limits, double seconds) {
  // No farther than at full speed all the time.
  const auto count = static_cast<size_t>(limits.speed_mps * seconds / kProfileStep) + 2;
  for (size_t i = 0; i < count; ++i) {
    double bend = 1e-9;  // The sharpest within a step, so that it holds between entries too.
    for (const double offset : {-0.75, -0.5, -0.25, 0.0, 0.25, 0.5, 0.75}) {
      const double s = (static_cast<double>(i) + offset) * kProfileStep;
      bend = std::max(bend, std::abs(curve.At(s).curvature));
    }
    speed_.push_back(std::min(
        {limits.speed_mps, std::sqrt(limits.lateral_mps2 / bend), limits.yaw_rate_radps / bend}));
  }
  speed_[0] = 0;
  const double gain = 2 * limits.acceleration_mps2 * kProfileStep;  // The speed's square, per step.
  const auto limit = [&](size_t i, size_t from) {
    speed_[i] = std::min(speed_[i], std::sqrt(speed_[from] * speed_[from] + gain));
  };
  for (size_t i = 1; i < count; ++i) limit(i, i - 1);
  for (size_t i = count - 1; i-- > 1;) limit(i, i + 1);
  time_.push_back(0);
  for (size_t i = 1; i < count; ++i) {
    time_.push_back(time_.back() + 2 * kProfileStep / (speed_[i - 1] + speed_[i]));
  }
}

SpeedProfile::State SpeedProfile::At(double seconds) const {
  if (seconds <= 0) return {};
  const auto next = std::upper_bound(time_.begin() + 1, time_.end() - 1, seconds);
  const size_t i = static_cast<size_t>(next - time_.begin()) - 1;
  const double acceleration =
      (speed_[i + 1] * speed_[i + 1] - speed_[i] * speed_[i]) / (2 * kProfileStep);
  const double dt = seconds - time_[i];
  return {static_cast<double>(i) * kProfileStep + speed_[i] * dt + acceleration * dt * dt / 2,
          speed_[i] + acceleration * dt};
}

double SpeedProfile::TimeAt(double s) const {
  const auto i = static_cast<size_t>(std::ceil(s / kProfileStep));
  return i < time_.size() ? time_[i] : std::numeric_limits<double>::infinity();
}

}  // namespace isthmus::simulation
