#include "server/matching/registration/alignment_quality.h"

#include <algorithm>
#include <cmath>

#include "server/matching/registration/limits.h"
#include "server/matching/registration/pose_problem.h"

namespace isthmus::matching {
namespace {

size_t StrideOf(const RefinableMap::Data& map) { return map.points.size() / kMaxOverlapPoints + 1; }

// Point-to-plane pairs of an even sample of `moving` on `fixed`; p is the point in the frame of
// `moving`.
std::vector<Correspondence> FindPlanePairs(const RefinableMap::Data& fixed,
                                           const RefinableMap::Data& moving,
                                           const Pose& T_fixed_moving, double distance_m) {
  std::vector<Correspondence> pairs;
  const Eigen::Matrix3f R = T_fixed_moving.RotationMatrix().cast<float>();
  const Eigen::Vector3f t = T_fixed_moving.translation().cast<float>();
  const float reach = static_cast<float>(std::max(distance_m, fixed.voxel_m));
  for (size_t i = 0; i < moving.points.size(); i += StrideOf(moving)) {
    const SurfacePoint& point = moving.points[i];
    const Eigen::Vector3f n = R * point.normal;
    const Eigen::Vector3f p = R * point.position + t;
    const auto neighbor = fixed.tree.NearestIf(
        p, reach, [&](int j) { return fixed.points[j].normal.dot(n) > kMinNormalCosine; });
    if (neighbor.index < 0) continue;
    const SurfacePoint& q = fixed.points[neighbor.index];
    if (std::abs(q.normal.dot(q.position - p)) > distance_m) continue;
    const Eigen::Vector3d normal = q.normal.cast<double>();
    pairs.push_back(
        {point.position.cast<double>(), q.position.cast<double>(), normal * normal.transpose()});
  }
  return pairs;
}

// Pairs of b on a from those of a on b.
void SwapSides(const Pose& T_a_b, std::vector<Correspondence>* pairs) {
  const Eigen::Matrix3d R = T_a_b.RotationMatrix();
  for (Correspondence& pair : *pairs) {
    std::swap(pair.p_b, pair.q_a);
    pair.weight = R * pair.weight * R.transpose();
  }
}

}  // namespace

void MeasureAlignment(const RefinableMap::Data& a, const RefinableMap::Data& b, double distance_m,
                      Refinement* result) {
  const bool b_is_smaller = b.points.size() <= a.points.size();
  const RefinableMap::Data& smaller = b_is_smaller ? b : a;
  if (smaller.points.empty()) return;
  const size_t asked = (smaller.points.size() - 1) / StrideOf(smaller) + 1;
  std::vector<Correspondence> pairs =
      b_is_smaller ? FindPlanePairs(a, b, result->T_a_b, distance_m)
                   : FindPlanePairs(b, a, result->T_a_b.Inverse(), distance_m);
  if (!b_is_smaller) SwapSides(result->T_a_b, &pairs);
  if (pairs.empty()) return;

  Eigen::Vector3d center = Eigen::Vector3d::Zero();
  for (const Correspondence& pair : pairs) center += pair.q_a;
  center /= static_cast<double>(pairs.size());
  const NormalEquations equations = Linearize(pairs, result->T_a_b, center);
  const double count = static_cast<double>(pairs.size());
  result->inliers = static_cast<int64_t>(pairs.size());
  result->overlap = count / static_cast<double>(asked);
  result->residual_m = std::sqrt(2.0 * equations.cost / count);
  const double sigma = std::max(result->residual_m, kMinSigmaM);
  result->information = MoveInformationToOrigin(equations.H / (sigma * sigma), center);
}

}  // namespace isthmus::matching
