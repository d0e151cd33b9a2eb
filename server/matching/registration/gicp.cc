#include "server/matching/registration/gicp.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "server/matching/registration/limits.h"

namespace isthmus::matching {
namespace {

double Median(std::vector<double>* values) {
  if (values->empty()) return 0;
  const auto middle = values->begin() + static_cast<std::ptrdiff_t>(values->size() / 2);
  std::nth_element(values->begin(), middle, values->end());
  return *middle;
}

}  // namespace

double LeastGate(double voxel_m) { return kMinGateVoxels * voxel_m; }

double NextGate(double gate_m, double median_normal_distance_m, double voxel_m) {
  const double wanted = kGatePerError * median_normal_distance_m + voxel_m;
  return std::clamp(wanted, std::max(LeastGate(voxel_m), kGateShare * gate_m), gate_m);
}

float AcrossCovariance(const SurfacePoint& point) { return std::max(kMinAcross, point.roughness); }

Eigen::Matrix3d DiscInformation(const Eigen::Vector3d& n_a, double across_a,
                                const Eigen::Vector3d& n_b, double across_b) {
  // C = I - (1 - across) n n^T: 1 along the disc, `across` through it.
  const Eigen::Matrix3d C = 2.0 * Eigen::Matrix3d::Identity() -
                            (1.0 - across_a) * n_a * n_a.transpose() -
                            (1.0 - across_b) * n_b * n_b.transpose();
  return C.inverse();
}

void ApplyRobustWeights(const Pose& T_a_b, double floor, std::vector<Correspondence>* pairs) {
  const Eigen::Matrix3d R = T_a_b.RotationMatrix();
  std::vector<double> errors;
  errors.reserve(pairs->size());
  for (const Correspondence& pair : *pairs) {
    const Eigen::Vector3d d = pair.q_a - (R * pair.p_b + T_a_b.translation());
    errors.push_back(d.dot(pair.weight * d));
  }
  std::vector<double> sorted = errors;
  const double scale = std::max(floor, 3.0 * Median(&sorted));
  for (size_t i = 0; i < pairs->size(); ++i) {
    const double root = scale / (scale + errors[i]);
    (*pairs)[i].weight *= root * root;
  }
}

void FindGicpPairs(const std::vector<SurfacePoint>& a, const KdTree& tree_a,
                   const std::vector<SurfacePoint>& b, const std::vector<int>& sample,
                   const Pose& T_a_b, double gate_m, PairSet* result) {
  result->pairs.clear();
  const Eigen::Matrix3f R = T_a_b.RotationMatrix().cast<float>();
  const Eigen::Vector3f t = T_a_b.translation().cast<float>();
  std::vector<double> distances;
  distances.reserve(sample.size());
  for (int i : sample) {
    const Eigen::Vector3f p = R * b[i].position + t;
    const Eigen::Vector3f n = R * b[i].normal;
    const auto neighbor = tree_a.NearestIf(p, static_cast<float>(gate_m), [&](int j) {
      return a[j].normal.dot(n) > kMinNormalCosine;
    });
    if (neighbor.index < 0) continue;
    const SurfacePoint& q = a[neighbor.index];
    distances.push_back(std::abs(q.normal.dot(q.position - p)));
    result->pairs.push_back({b[i].position.cast<double>(), q.position.cast<double>(),
                             DiscInformation(q.normal.cast<double>(), AcrossCovariance(q),
                                             n.cast<double>(), AcrossCovariance(b[i]))});
  }
  result->median_normal_distance_m = Median(&distances);
  ApplyRobustWeights(T_a_b, kNoiseFloor, &result->pairs);
}

}  // namespace isthmus::matching
