#include "server/matching/pairs/submap_alignment.h"

#include <algorithm>
#include <cmath>

#include "server/matching/pairs/limits.h"
#include "server/matching/prepared/limits.h"
#include "server/matching/registration/gicp.h"
#include "server/matching/registration/limits.h"
#include "server/matching/registration/pose_problem.h"

namespace isthmus::matching {
namespace {

// The point of the surface that a point with normal `n` lies on; below zero where it lies on none.
int FindOnSurface(const PreparedSubmap& a, const Eigen::Vector3f& p, const Eigen::Vector3f& n) {
  const auto neighbor = a.tree().NearestIf(p, 2 * static_cast<float>(kOnSurfaceM), [&](int j) {
    return a.surface()[j].normal.dot(n) > kMinNormalCosine;
  });
  if (neighbor.index < 0) return -1;
  const SurfacePoint& q = a.surface()[neighbor.index];
  return std::abs(q.normal.dot(q.position - p)) <= kOnSurfaceM ? neighbor.index : -1;
}

// The share that lies on a's surface, of what faces up or down in b's sample and is near it.
double LevelShare(const PreparedSubmap& a, const PreparedSubmap& b, const Pose& T_a_b) {
  const Eigen::Matrix3f R = T_a_b.RotationMatrix().cast<float>();
  const Eigen::Vector3f t = T_a_b.translation().cast<float>();
  const Eigen::Vector3f up =
      (a.submap().T_odom_submap.rotation().inverse() * Eigen::Vector3d::UnitZ()).cast<float>();
  double near = kFewLevelNormals, on = kFewLevelNormals;
  for (int i : b.sample()) {
    const Eigen::Vector3f p = R * b.surface()[i].position + t;
    const Eigen::Vector3f n = R * b.surface()[i].normal;
    const bool is_on = FindOnSurface(a, p, n) >= 0;
    if (!is_on && a.tree().Nearest(p, kSeenM).index < 0) continue;
    const double vertical = up.dot(n);
    near += vertical * vertical;
    on += is_on ? vertical * vertical : 0;
  }
  return on / near;
}

bool AreOnOneLevel(const PreparedSubmap& a, const PreparedSubmap& b, const Pose& T_a_b) {
  return std::min(LevelShare(a, b, T_a_b), LevelShare(b, a, T_a_b.Inverse())) >= kLeastLevelShare;
}

// Point-to-plane information about frame a's origin.
Matrix6d PlaneInformation(const PreparedSubmap& a, const PreparedSubmap& b, const Pose& T_a_b,
                          int* inliers) {
  const Eigen::Matrix3f R = T_a_b.RotationMatrix().cast<float>();
  const Eigen::Vector3f t = T_a_b.translation().cast<float>();
  std::vector<Correspondence> pairs;
  Eigen::Vector3d center = Eigen::Vector3d::Zero();
  for (int i : b.sample()) {
    const Eigen::Vector3f p = R * b.surface()[i].position + t;
    const Eigen::Vector3f n = R * b.surface()[i].normal;
    const int neighbor = FindOnSurface(a, p, n);
    if (neighbor < 0) continue;
    const SurfacePoint& q = a.surface()[neighbor];
    const Eigen::Vector3d normal = q.normal.cast<double>();
    pairs.push_back({b.surface()[i].position.cast<double>(), q.position.cast<double>(),
                     normal * normal.transpose()});
    center += pairs.back().q_a;
  }
  *inliers = static_cast<int>(pairs.size());
  if (pairs.empty()) return Matrix6d::Zero();
  const double count = static_cast<double>(pairs.size());
  center /= count;
  const NormalEquations equations = Linearize(pairs, T_a_b, center);
  const double sigma = std::max(std::sqrt(2 * equations.cost / count), kMinSigmaM);
  const double weight = std::min(1.0, kIndependentPairs / count) / (sigma * sigma);
  return MoveInformationToOrigin(weight * equations.H, center);
}

}  // namespace

std::optional<SubmapAlignment> AlignSubmaps(const PreparedSubmap& a, const PreparedSubmap& b,
                                            const Pose& guess_T_a_b, double gate_m) {
  SubmapAlignment result;
  result.T_a_b = guess_T_a_b;
  const double min_gate = LeastGate(a.voxel_m());
  double gate = std::max(gate_m, min_gate);
  PairSet found;
  bool settled = false;
  for (int i = 0; i < kAlignmentRounds && !settled; ++i) {
    FindGicpPairs(a.surface(), a.tree(), b.surface(), b.sample(), result.T_a_b, gate, &found);
    if (found.pairs.size() < kMinAlignedPairs) return std::nullopt;
    Vector6d twist;
    if (!StepPose(found.pairs, kDamping, &result.T_a_b, &twist)) return std::nullopt;
    const double shrunk = NextGate(gate, found.median_normal_distance_m, a.voxel_m());
    settled = IsSmallStep(twist, kAlignmentStepM) && shrunk > 0.99 * gate;
    gate = shrunk;
  }
  const Pose moved = guess_T_a_b.Inverse() * result.T_a_b;
  const Eigen::Vector3d& middle = b.center();
  if (!((moved * middle - middle).norm() < std::max(gate_m, min_gate))) return std::nullopt;
  if (!AreOnOneLevel(a, b, result.T_a_b)) return std::nullopt;
  result.information = PlaneInformation(a, b, result.T_a_b, &result.inliers);
  if (result.inliers < static_cast<int>(kMinAlignedPairs)) return std::nullopt;
  return result;
}

}  // namespace isthmus::matching
