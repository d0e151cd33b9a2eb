#include "floam/match/scan_matcher.h"

#include <algorithm>
#include <cmath>

#include "floam/match/match_information.h"
#include "floam/scan/undistort.h"

namespace isthmus::floam {
namespace {

std::pair<double, double> TimeSpan(const Features& features) {
  double begin = 0, end = -1e9;
  for (const auto* points : {&features.surfaces, &features.edges}) {
    for (const TimedPoint& p : *points) {
      begin = std::min<double>(begin, p.time);
      end = std::max<double>(end, p.time);
    }
  }
  return {begin, std::max(begin, end)};
}

// Adds the prior on the twist: residual e = twist - Log(T_previous^-1 T) / dt, whose derivative by
// a motion d of T is -1 / dt to first order.
void AddPrior(const TwistPrior& prior, const ScanPose& pose, MatchSums* sums) {
  const bool coupled = prior.since_previous_s > 0;
  Vector6d residual = pose.twist - prior.mean;
  if (coupled) {
    const Vector6d motion = Log(prior.T_odom_previous.Inverse() * pose.T_odom_sensor);
    residual = pose.twist - motion / prior.since_previous_s;
  }
  Matrix12d& H = sums->information;
  Vector12d& g = sums->gradient;
  const double slope = coupled ? -1 / prior.since_previous_s : 0;
  for (int k = 0; k < 6; ++k) {
    const double weight = 1 / (prior.sigma[k] * prior.sigma[k]);
    H(k, k) += weight * slope * slope;
    H(k, 6 + k) += weight * slope;
    H(6 + k, k) += weight * slope;
    H(6 + k, 6 + k) += weight;
    g[k] += weight * slope * residual[k];
    g[6 + k] += weight * residual[k];
  }
}

}  // namespace

Matrix6d FreeMotion(const MatchOptions& options) {
  return Isotropic(options.free_sigma_m, options.free_sigma_rad);
}

struct ScanMatcher::Pass {
  Pass(const ScanPose& scan_pose, const ScanMotion& scan_motion)
      : pose(scan_pose),
        motion(scan_motion),
        rotation(scan_pose.T_odom_sensor.RotationMatrix()),
        translation(scan_pose.T_odom_sensor.translation()) {}

  const ScanPose& pose;
  const ScanMotion& motion;
  const Eigen::Matrix3d rotation;
  const Eigen::Vector3d translation;
  double kernel2 = 0;

  int used = 0;
  double agreement = 0;  // Sum of robust weights ...
  double standing = 0;   // ... and of those of edges and poles.
  std::vector<MatchRow>* rows = nullptr;

  // The distance of q (sensor frame, at the reference time) to the plane across `normal` (sensor
  // frame), `offset` (odom) from its middle.
  void AddRow(const Eigen::Vector3d& q, const Eigen::Vector3d& offset,
              const Eigen::Vector3d& normal, double residual, double time_s, double weight,
              double tilt_variance) {
    rows->push_back({PoseJacobian(q, normal), weight, residual, time_s - pose.reference_s, q,
                     rotation.transpose() * offset, tilt_variance});
  }
  // The same to a line, the one in which planes across u and v (odom) meet.
  void AddRows(const Eigen::Vector3d& q, const Eigen::Vector3d& offset, const Eigen::Vector3d& u,
               const Eigen::Vector3d& v, double time_s, double weight, double tilt_variance) {
    for (const Eigen::Vector3d& n : {u, v}) {
      AddRow(q, offset, rotation.transpose() * n, n.dot(offset), time_s, weight, tilt_variance);
    }
  }

  // Geman-McClure: rho(r) = r^2 / (1 + r^2 / c^2), so the weight is 1 / (1 + r^2 / c^2)^2.
  double RobustWeight(double residual2) const {
    const double ratio = kernel2 / (kernel2 + residual2);
    return ratio * ratio;
  }
  double Use(double residual2) {
    const double weight = RobustWeight(residual2);
    agreement += weight;
    ++used;
    return weight;
  }
};

void ScanMatcher::AccumulateSurfaces(const Features& features, const MatchOptions& options,
                                     Pass* pass, LocalMap* map) {
  const double noise2 = options.point_noise_m * options.point_noise_m;
  for (size_t i = 0; i < features.surfaces.size(); i += options.stride) {
    const TimedPoint& point = features.surfaces[i];
    const Eigen::Vector3d q = pass->motion.ToReference(point.position, point.time).cast<double>();
    const Eigen::Vector3d p = pass->rotation * q + pass->translation;
    LocalMap::Found& found = found_surfaces_[i];
    map->Find(p, &found);
    if (found.shape == nullptr) continue;
    const Eigen::Vector3d normal = found.shape->direction.cast<double>();
    const Eigen::Vector3d offset = p - found.origin - found.shape->mean.cast<double>();
    const double residual = normal.dot(offset);
    if (std::abs(residual) > options.gate_m) continue;
    const double weight =
        pass->Use(residual * residual) * point.weight / (noise2 + found.shape->variance);
    const Eigen::Vector3d seen = pass->rotation.transpose() * normal;
    if (i < features.chords.size() && !MayBe(features.chords[i], seen.cast<float>())) continue;
    pass->AddRow(q, offset, seen, residual, point.time, weight, found.shape->tilt_variance);
  }
}

void ScanMatcher::AccumulateEdges(const Features& features, const MatchOptions& options, Pass* pass,
                                  LocalMap* map) {
  const double noise2 = options.point_noise_m * options.point_noise_m;
  for (size_t i = 0; i < features.edges.size(); i += options.stride) {
    const TimedPoint& point = features.edges[i];
    const Eigen::Vector3d q = pass->motion.ToReference(point.position, point.time).cast<double>();
    const Eigen::Vector3d p = pass->rotation * q + pass->translation;
    LocalMap::Found& found = found_edges_[i];
    map->Find(p, &found);
    if (found.shape == nullptr) continue;
    const Eigen::Vector3d along = found.shape->direction.cast<double>();
    const Eigen::Vector3d offset = p - found.origin - found.shape->mean.cast<double>();
    const Eigen::Vector3d u = along.unitOrthogonal();
    const Eigen::Vector3d v = along.cross(u);
    const double residual2 = std::pow(u.dot(offset), 2) + std::pow(v.dot(offset), 2);
    if (residual2 > options.gate_m * options.gate_m) continue;
    const double robust = pass->Use(residual2);
    pass->standing += robust;
    const double weight = robust * point.weight / (noise2 + found.shape->variance);
    pass->AddRows(q, offset, u, v, point.time, weight, found.shape->tilt_variance);
  }
}

// Poles are hit at any height: what they tell is along the ray and across it on the level. They do
// not count as used, for whatever stands about may be somebody.
void ScanMatcher::AccumulatePoles(const Features& features, const MatchOptions& options, Pass* pass,
                                  LocalMap* map) {
  const double noise2 = options.pole_noise_m * options.pole_noise_m;
  for (size_t i = 0; i < features.poles.size(); ++i) {
    const TimedPoint& point = features.poles[i];
    const Eigen::Vector3d q = pass->motion.ToReference(point.position, point.time).cast<double>();
    const Eigen::Vector3d p = pass->rotation * q + pass->translation;
    LocalMap::Found& found = found_poles_[i];
    map->Find(p, &found);
    if (found.shape == nullptr) continue;
    const Eigen::Vector3d offset = p - found.origin - found.shape->mean.cast<double>();
    const Eigen::Vector3d u = pass->rotation * q.normalized();
    const Eigen::Vector3d v = pass->rotation * Eigen::Vector3d::UnitZ().cross(q).normalized();
    const double residual2 = std::pow(u.dot(offset), 2) + std::pow(v.dot(offset), 2);
    if (residual2 > options.gate_m * options.gate_m) continue;
    const double robust = pass->RobustWeight(residual2);
    pass->standing += robust;
    const double weight = robust / (noise2 + found.shape->variance);
    pass->AddRows(q, offset, u, v, point.time, weight, 0);
  }
}

MatchResult ScanMatcher::Match(const Features& features, const ScanPose& guess,
                               const PosePrior& pose_prior,
                               const std::optional<TwistPrior>& twist_prior,
                               const MatchOptions& options, LocalMap* surfaces, LocalMap* edges,
                               LocalMap* poles) {
  found_surfaces_.assign(features.surfaces.size(), LocalMap::Found());
  found_edges_.assign(features.edges.size(), LocalMap::Found());
  found_poles_.assign(features.poles.size(), LocalMap::Found());
  const auto [begin_s, end_s] = TimeSpan(features);
  MatchResult result;
  result.pose = guess;
  const size_t stride = options.stride;
  result.features = static_cast<int>((features.surfaces.size() + stride - 1) / stride +
                                     (features.edges.size() + stride - 1) / stride);
  result.standing_tried = static_cast<int>((features.edges.size() + stride - 1) / stride +
                                           (poles != nullptr ? features.poles.size() : 0));
  double kernel = options.kernel_start_m;
  for (int iteration = 0; iteration < options.max_iterations; ++iteration) {
    features.work.Add(Work::Kind::kMap, result.features + features.poles.size());
    if (features.work.spent()) break;
    const ScanMotion motion(result.pose.twist, result.pose.reference_s, begin_s, end_s);
    Pass pass(result.pose, motion);
    pass.kernel2 = kernel * kernel;
    rows_.clear();
    pass.rows = &rows_;
    const bool with_twist = twist_prior.has_value() && iteration >= options.pose_only_iterations;
    AccumulateSurfaces(features, options, &pass, surfaces);
    AccumulateEdges(features, options, &pass, edges);
    if (poles != nullptr) AccumulatePoles(features, options, &pass, poles);
    result.iterations = iteration + 1;
    result.used = pass.used;
    result.agreement = pass.used > 0 ? pass.agreement / pass.used : 0;
    result.standing = pass.standing / std::max(result.standing_tried, 1);

    MatchSums sums = SumOf(rows_, with_twist);
    if (with_twist)
      AddPrior(*twist_prior, result.pose, &sums);
    else
      sums.information.bottomRightCorner<6, 6>().setIdentity();

    const Vector6d offset = Log(pose_prior.T_odom_sensor.Inverse() * result.pose.T_odom_sensor);
    const JointEstimate estimate = Solve(sums, rows_, pose_prior.covariance, offset);
    const Vector12d& step = estimate.step;
    if (!step.allFinite()) return result;
    result.pose.T_odom_sensor = result.pose.T_odom_sensor * Exp(step.head<6>());
    if (with_twist) result.pose.twist += step.tail<6>();
    result.covariance = estimate.covariance;
    result.information = estimate.match_information;
    const bool settled = kernel <= options.kernel_m;
    kernel = std::max(options.kernel_m, kernel / 2);
    const bool last_stage = with_twist || !twist_prior.has_value();
    const bool small =
        step.head<3>().norm() < options.stop_m && step.segment<3>(3).norm() < options.stop_rad;
    if (settled && last_stage && small) break;
  }
  result.degeneracy = FindDegeneracy(result.information, FreeMotion(options));
  result.map_degeneracy = result.degeneracy;
  return result;
}

}  // namespace isthmus::floam
