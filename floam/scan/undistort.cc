#include "floam/scan/undistort.h"

#include <algorithm>

namespace isthmus::floam {

ScanMotion::ScanMotion(const Vector6d& twist_per_s, double reference_s, double begin_s,
                       double end_s)
    : begin_s_(static_cast<float>(begin_s)) {
  const double step_s = std::max(end_s - begin_s, 1e-6) / kIntervals;
  knots_per_s_ = static_cast<float>(1 / step_s);
  last_position_ = kIntervals - 1e-4F;
  knots_.reserve(kIntervals + 1);
  // The twist is constant, so every knot is the same step after the one before.
  Pose T_reference_sensor = Exp((begin_s - reference_s) * twist_per_s);
  const Pose T_step = Exp(step_s * twist_per_s);
  for (int k = 0; k <= kIntervals; ++k) {
    const Eigen::Matrix4f matrix = T_reference_sensor.Matrix().cast<float>();
    knots_.push_back({matrix.col(0), matrix.col(1), matrix.col(2), matrix.col(3)});
    T_reference_sensor = T_reference_sensor * T_step;
  }
}

void Undistort(const RingScan& scan, const ScanMotion& motion, Cloud* out) {
  out->resize(scan.points.size());
  for (size_t i = 0; i < scan.points.size(); ++i) {
    const RingPoint& p = scan.points[i];
    const Eigen::Array4f q = motion.ToReference(p.x, p.y, p.z, p.time);
    Eigen::Map<Eigen::Array4f>(&(*out)[i].x) = q;
    (*out)[i].intensity = p.intensity;
  }
}

}  // namespace isthmus::floam
