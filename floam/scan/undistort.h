// Motion within a scan, and its removal.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/cloud.h"
#include "core/pose.h"
#include "floam/rings/ring_scan.h"

namespace isthmus::floam {

// A sensor moving with a constant twist (per second, [rho; phi], its own frame): at time t its pose
// relative to where it is at `reference_s` is Exp((t - reference_s) * twist). Immutable.
class ScanMotion {
 public:
  // Holds for t in [begin_s, end_s]; times outside are moved to the nearer end.
  ScanMotion(const Vector6d& twist_per_s, double reference_s, double begin_s, double end_s);

  // A point in the sensor frame at time `t` to the sensor frame at the reference time. Interpolates
  // a table of poses; off by less than 0.1 mm at 100 m and 60 degrees per 0.1 s.
  Eigen::Vector3f ToReference(const Eigen::Vector3f& p, float t) const {
    return ToReference(p.x(), p.y(), p.z(), t).matrix().head<3>();
  }
  // The same; a fourth number, for the sake of vector units, means nothing.
  Eigen::Array4f ToReference(float x, float y, float z, float t) const {
    const float position = std::min(std::max((t - begin_s_) * knots_per_s_, 0.F), last_position_);
    const int knot = static_cast<int>(position);
    const float f = position - static_cast<float>(knot);
    const Knot& a = knots_[knot];
    const Knot& b = knots_[knot + 1];
    const Eigen::Array4f at_a = a.x * x + a.y * y + a.z * z + a.origin;
    const Eigen::Array4f at_b = b.x * x + b.y * y + b.z * z + b.origin;
    return at_a + f * (at_b - at_a);
  }

 private:
  static constexpr int kIntervals = 64;
  // Columns of the pose's upper rows, each with a fourth number for the sake of vector units.
  struct Knot {
    Eigen::Array4f x, y, z, origin;
  };

  float begin_s_, knots_per_s_, last_position_;
  std::vector<Knot> knots_;
};

// All points of the scan in the sensor frame at the reference time of `motion`.
void Undistort(const RingScan& scan, const ScanMotion& motion, Cloud* out);

}  // namespace isthmus::floam
