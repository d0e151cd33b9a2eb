#include "server/matching/pairs/submap_alignment.h"

#include <algorithm>
#include <cmath>

#include "server/matching/pairs/limits.h"
#include "server/matching/registration/gicp.h"
#include "server/matching/registration/limits.h"
#include "server/matching/registration/pose_problem.h"

namespace isthmus::matching {
namespace {

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
    const auto neighbor = a.tree().NearestIf(p, 2 * static_cast<float>(kOnSurfaceM), [&](int j) {
      return a.surface()[j].normal.dot(n) > kMinNormalCosine;
    });
    if (neighbor.index < 0) continue;
    const SurfacePoint& q = a.surface()[neighbor.index];
    if (std::abs(q.normal.dot(q.position - p)) > kOnSurfaceM) continue;
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
  result.information = PlaneInformation(a, b, result.T_a_b, &result.inliers);
  if (result.inliers < static_cast<int>(kMinAlignedPairs)) return std::nullopt;
  return result;
}

SurfaceAgreement& SurfaceAgreement::operator+=(const SurfaceAgreement& other) {
  asked += other.asked;
  near += other.near;
  on += other.on;
  squared_m2 += other.squared_m2;
  scatter += other.scatter;
  return *this;
}

SurfaceAgreement MeasureAgreement(const PreparedSubmap& submap, const Pose& T_common_submap,
                                  const PreparedSubmaps& map, const std::vector<Pose>& T_common_map,
                                  double distance_m) {
  struct Target {
    const PreparedSubmap* submap;
    Eigen::Matrix3f R;  // To the target's frame.
    Eigen::Vector3f t;
    Eigen::Matrix3d R_common;  // From there to the common frame.
    float reach;
  };
  std::vector<Target> targets;
  for (size_t i = 0; i < map.size(); ++i) {
    const Pose T = T_common_map[i].Inverse() * T_common_submap;
    const double apart = (T * submap.center() - map[i]->center()).norm();
    if (apart > submap.radius_m() + map[i]->radius_m() + kSeenM) continue;
    targets.push_back({map[i].get(), T.RotationMatrix().cast<float>(),
                       T.translation().cast<float>(), T_common_map[i].RotationMatrix(),
                       static_cast<float>(std::max(distance_m, map[i]->voxel_m()))});
  }
  SurfaceAgreement result;
  const std::vector<SurfacePoint>& points = submap.surface();
  const size_t stride = points.size() / kMaxAgreementPoints + 1;
  for (size_t k = 0; k < points.size(); k += stride) {
    ++result.asked;
    bool near = false, on = false;
    for (const Target& target : targets) {
      const Eigen::Vector3f p = target.R * points[k].position + target.t;
      const Eigen::Vector3f n = target.R * points[k].normal;
      const std::vector<SurfacePoint>& surface = target.submap->surface();
      const auto neighbor = target.submap->tree().NearestIf(
          p, target.reach, [&](int j) { return surface[j].normal.dot(n) > kMinNormalCosine; });
      if (neighbor.index < 0) {
        near = near || target.submap->tree().Nearest(p, kSeenM).index >= 0;
        continue;
      }
      near = true;
      const SurfacePoint& q = surface[neighbor.index];
      const double off = q.normal.dot(q.position - p);
      if (std::abs(off) > distance_m) continue;
      on = true;
      result.squared_m2 += off * off;
      Eigen::Matrix<double, 3, 6> J;
      J.leftCols<3>().setIdentity();
      J.rightCols<3>() = -Skew(T_common_submap * points[k].position.cast<double>());
      const Eigen::Matrix<double, 1, 6> row =
          (target.R_common * q.normal.cast<double>()).transpose() * J;
      result.scatter.noalias() += row.transpose() * row;
      break;
    }
    result.near += near;
    result.on += on;
  }
  return result;
}

}  // namespace isthmus::matching
