// Angles of points, fast enough to be taken of every point of every scan.
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>

namespace isthmus {

inline constexpr float kPi = std::numbers::pi_v<float>;
inline constexpr float kDegree = kPi / 180;
inline constexpr double kRadPerDeg = std::numbers::pi / 180;

// atan2 to 1e-5 rad, which is 0.2 us of a turn at 10 Hz. Zero for the origin. Polynomial of
// Abramowitz and Stegun, "Handbook of Mathematical Functions", 4.4.49.
inline float FastAtan2(float y, float x) {
  const float ax = std::abs(x), ay = std::abs(y);
  const float big = std::max(ax, ay), small = std::min(ax, ay);
  const float a = small / std::max(big, 1e-30F);
  const float s = a * a;
  float angle =
      a * (0.9998660F + s * (-0.3302995F + s * (0.1801410F + s * (-0.0851330F + s * 0.0208351F))));
  if (ay > ax) angle = 1.57079633F - angle;
  if (x < 0) angle = 3.14159265F - angle;
  return y < 0 ? -angle : angle;
}

// The same angle in (-pi, pi], for angles that are off by at most one turn.
inline float WrapOnce(float angle) {
  if (angle > kPi) return angle - 2 * kPi;
  if (angle <= -kPi) return angle + 2 * kPi;
  return angle;
}

// The distance to the next lower whole number, in [0, 1].
inline float Fraction(float v) {
  const auto whole = static_cast<float>(static_cast<int>(v));
  return v - (v < whole ? whole - 1 : whole);
}

}  // namespace isthmus
