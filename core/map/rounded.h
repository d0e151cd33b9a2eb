// Coordinates as a store gives them back.
#pragma once

#include <cmath>

namespace isthmus {

// The step to which stores round points of submaps by default, metres. Points that are rounded so
// before they are stored are the same before and after a restart.
inline constexpr double kStoredStepM = 0.001;

// To the nearest multiple of `step`, as codec::Quantize does; `v` where that has more digits than
// there are.
inline float Rounded(float v, double step) {
  const double steps = static_cast<double>(v) * (1 / step);
  if (!(std::abs(steps) < 1e15)) return v;
  return static_cast<float>(static_cast<double>(std::llround(steps)) * step);
}

}  // namespace isthmus
