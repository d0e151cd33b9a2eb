#include "core/geometry/near_origin.h"

#include <absl/strings/str_cat.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace isthmus {
namespace {

// Metres: what is farther is moved, by whole steps. Within, coordinates of 32 bits have a tenth of
// a millimetre, and a map of 3 km around stays within the 5 km that a submap may have.
constexpr double kFarFromOriginM = 2000, kFarStepM = 1000;
// Metres: no coordinates on Earth are farther out.
constexpr double kNowhereM = 1e9;

double MedianOf(std::vector<double> values) {
  std::erase_if(values, [](double value) { return !std::isfinite(value); });
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace

Eigen::Vector3d ShiftToOrigin(const Eigen::Vector3d& place) {
  const double farthest_m = place.cwiseAbs().maxCoeff();
  if (!place.allFinite() || farthest_m <= kFarFromOriginM || farthest_m > kNowhereM) {
    return Eigen::Vector3d::Zero();
  }
  // Adding 0 makes a zero of what would be a negative one.
  return place.unaryExpr([](double v) { return -std::trunc(v / kFarStepM) * kFarStepM + 0.0; });
}

Eigen::Vector3d MiddleOf(const std::vector<double>& x, const std::vector<double>& y,
                         const std::vector<double>& z) {
  return {MedianOf(x), MedianOf(y), MedianOf(z)};
}

std::string ShiftText(const std::string& file, const Eigen::Vector3d& shift) {
  const auto metres = shift.cast<int64_t>();
  return absl::StrCat(file, " is far from its origin: ", metres.x(), " ", metres.y(), " ",
                      metres.z(), " m are added to its coordinates");
}

}  // namespace isthmus
