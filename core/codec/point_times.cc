#include "core/codec/point_times.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace isthmus::codec {
namespace {

// A spinning LiDAR turns 2 to 50 times a second. The longest turn is less than a thousand times
// the shortest, so at most one of the units below fits.
constexpr double kShortestTurn_s = 0.02;
constexpr double kLongestTurn_s = 0.5;
// A part of a turn may be shorter; below this the field carries no time at all.
constexpr double kShortestPart_s = 1e-3;
constexpr std::array<double, 4> kUnits_s = {1, 1e-3, 1e-6, 1e-9};

}  // namespace

double SecondsPerUnit(ScalarType type, double span) {
  for (const double unit : kUnits_s) {
    if (span * unit >= kShortestTurn_s && span * unit <= kLongestTurn_s) return unit;
  }
  const bool floating = type == ScalarType::kFloat32 || type == ScalarType::kFloat64;
  const double unit = floating ? 1.0 : 1e-9;
  return span * unit >= kShortestPart_s && span * unit <= kLongestTurn_s ? unit : 0;
}

bool MakeRelativeToEnd(ScalarType type, std::vector<double>& times) {
  if (times.empty()) return false;
  if (!std::all_of(times.begin(), times.end(), [](double t) { return std::isfinite(t); })) {
    return false;
  }
  const auto [first, last] = std::minmax_element(times.begin(), times.end());
  const double end = *last;
  const double unit = SecondsPerUnit(type, end - *first);
  if (unit == 0) return false;
  for (double& t : times) t = (t - end) * unit;
  return true;
}

}  // namespace isthmus::codec
