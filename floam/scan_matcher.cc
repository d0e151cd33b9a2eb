#include "floam/scan_matcher.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "floam/undistort.h"

namespace isthmus::floam {
namespace {

// Weight of the prediction along directions that are not observed: it decides there.
constexpr double kHoldPerMatch = 1e6;

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

// Selects translation and yaw: what the motion between scans says about the motion within one.
Vector6d Selected(const Vector6d& twist) {
  Vector6d selected = twist;
  selected[3] = selected[4] = 0;
  return selected;
}

// Adds the prior on the twist: residual e = twist - S Log(T_previous^-1 T) / dt, whose derivative
// by a motion d of T is -S / dt to first order.
void AddPrior(const TwistPrior& prior, const ScanPose& pose, Matrix12d* H, Vector12d* g) {
  const bool coupled = prior.since_previous_s > 0;
  Vector6d residual = pose.twist - prior.mean;
  if (coupled) {
    const Vector6d motion = Log(prior.T_odom_previous.Inverse() * pose.T_odom_sensor);
    residual = pose.twist - Selected(motion) / prior.since_previous_s;
  }
  for (int k = 0; k < 6; ++k) {
    const double weight = 1 / (prior.sigma[k] * prior.sigma[k]);
    const bool by_pose = coupled && k != 3 && k != 4;
    const double slope = by_pose ? -1 / prior.since_previous_s : 0;
    (*H)(k, k) += weight * slope * slope;
    (*H)(k, 6 + k) += weight * slope;
    (*H)(6 + k, k) += weight * slope;
    (*H)(6 + k, 6 + k) += weight;
    (*g)[k] += weight * slope * residual[k];
    (*g)[6 + k] += weight * residual[k];
  }
}

// Adds what is known of the pose beforehand.
void AddGuess(const Vector6d& sigma, const Pose& guess, const Pose& current, Matrix12d* H,
              Vector12d* g) {
  const Vector6d offset = Log(guess.Inverse() * current);
  const Vector6d weight = sigma.cwiseAbs2().cwiseInverse();  // Zero for an infinite sigma.
  H->diagonal().head<6>() += weight;
  g->head<6>() += weight.cwiseProduct(offset);
}

// Ties pose and twist to the guess along what is not observed. The twist too: what noise says of it
// there would carry the predictions of the scans to come away.
void HoldDegenerate(const Degeneracy& degeneracy, const ScanPose& guess, const ScanPose& current,
                    int used, Matrix12d* H, Vector12d* g) {
  const Vector6d offset = Log(guess.T_odom_sensor.Inverse() * current.T_odom_sensor);
  const Vector6d twist_offset = current.twist - guess.twist;
  const auto hold = [&](const Vector6d& direction, double weight) {
    const Matrix6d held = weight * direction * direction.transpose();
    H->topLeftCorner<6, 6>() += held;
    H->bottomRightCorner<6, 6>() += held;
    g->head<6>() += held * offset;
    g->tail<6>() += held * twist_offset;
  };
  const double weight = kHoldPerMatch * std::max(used, 1);
  for (const Eigen::Vector3d& d : degeneracy.translations) {
    hold((Vector6d() << d, Eigen::Vector3d::Zero()).finished(), weight);
  }
  for (const Eigen::Vector3d& d : degeneracy.rotations) {
    hold((Vector6d() << Eigen::Vector3d::Zero(), d).finished(), weight);
  }
}

}  // namespace

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
  bool with_twist = false;

  NormalEquations equations;
  int used = 0;
  double agreement = 0;  // Sum of robust weights.
  double lever2 = 0;     // Sum of squared distances from the sensor.

  // One residual: q in the sensor frame at the reference time, `normal` in odom.
  void AddRow(const Eigen::Vector3d& q, const Eigen::Vector3d& normal, double tau, double weight,
              double residual) {
    const Eigen::Vector3d rotated = rotation.transpose() * normal;
    equations.Add(PoseJacobian(q, rotated), tau, weight, residual, with_twist);
  }

  // Geman-McClure: rho(r) = r^2 / (1 + r^2 / c^2), so the weight is 1 / (1 + r^2 / c^2)^2.
  double RobustWeight(double residual2) {
    const double ratio = kernel2 / (kernel2 + residual2);
    agreement += ratio * ratio;
    ++used;
    return ratio * ratio;
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
    const double residual = normal.dot(p - found.origin - found.shape->mean.cast<double>());
    if (std::abs(residual) > options.gate_m) continue;
    const double weight =
        pass->RobustWeight(residual * residual) * point.weight / (noise2 + found.shape->variance);
    pass->lever2 += q.squaredNorm();
    pass->AddRow(q, normal, point.time - pass->pose.reference_s, weight, residual);
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
    // The distance to a line is the distances to two planes that meet in it.
    const Eigen::Vector3d along = found.shape->direction.cast<double>();
    const Eigen::Vector3d offset = p - found.origin - found.shape->mean.cast<double>();
    const Eigen::Vector3d u = along.unitOrthogonal();
    const Eigen::Vector3d v = along.cross(u);
    const double ru = u.dot(offset), rv = v.dot(offset);
    const double residual2 = ru * ru + rv * rv;
    if (residual2 > options.gate_m * options.gate_m) continue;
    const double weight =
        pass->RobustWeight(residual2) * point.weight / (noise2 + found.shape->variance);
    pass->lever2 += q.squaredNorm();
    const double tau = point.time - pass->pose.reference_s;
    pass->AddRow(q, u, tau, weight, ru);
    pass->AddRow(q, v, tau, weight, rv);
  }
}

MatchResult ScanMatcher::Match(const Features& features, const ScanPose& guess,
                               const std::optional<TwistPrior>& prior, const MatchOptions& options,
                               LocalMap* surfaces, LocalMap* edges) {
  found_surfaces_.assign(features.surfaces.size(), LocalMap::Found());
  found_edges_.assign(features.edges.size(), LocalMap::Found());
  const auto [begin_s, end_s] = TimeSpan(features);
  MatchResult result;
  result.pose = guess;
  const size_t stride = options.stride;
  result.features = static_cast<int>((features.surfaces.size() + stride - 1) / stride +
                                     (features.edges.size() + stride - 1) / stride);
  const double noise2 = options.point_noise_m * options.point_noise_m;
  double kernel = options.kernel_start_m;
  for (int iteration = 0; iteration < options.max_iterations; ++iteration) {
    const ScanMotion motion(result.pose.twist, result.pose.reference_s, begin_s, end_s);
    Pass pass(result.pose, motion);
    pass.kernel2 = kernel * kernel;
    pass.with_twist = prior.has_value() && iteration >= options.pose_only_iterations;
    AccumulateSurfaces(features, options, &pass, surfaces);
    AccumulateEdges(features, options, &pass, edges);
    result.iterations = iteration + 1;
    result.used = pass.used;
    result.agreement = pass.used > 0 ? pass.agreement / pass.used : 0;
    if (pass.used < 10) return result;

    Matrix12d H = pass.equations.Information();
    Vector12d g = pass.equations.Gradient();
    result.degeneracy = FindDegeneracy(noise2 * pass.equations.pose(), pass.used,
                                       std::sqrt(pass.lever2 / pass.used), options.least_share);
    AddGuess(options.guess_sigma, guess.T_odom_sensor, result.pose.T_odom_sensor, &H, &g);
    HoldDegenerate(result.degeneracy, guess, result.pose, pass.used, &H, &g);
    if (pass.with_twist)
      AddPrior(*prior, result.pose, &H, &g);
    else
      H.bottomRightCorner<6, 6>() += Matrix6d::Identity();

    const Eigen::LDLT<Matrix12d> solver(H);
    const Vector12d step = -solver.solve(g);
    if (!step.allFinite()) return result;
    result.pose.T_odom_sensor = result.pose.T_odom_sensor * Exp(step.head<6>());
    if (pass.with_twist) result.pose.twist += step.tail<6>();
    const bool settled = kernel <= options.kernel_m;
    kernel = std::max(options.kernel_m, kernel / 2);
    const bool last_stage = pass.with_twist || !prior.has_value();
    const bool small =
        step.head<3>().norm() < options.stop_m && step.segment<3>(3).norm() < options.stop_rad;
    if ((settled && last_stage && small) || iteration + 1 == options.max_iterations) {
      result.covariance = solver.solve(Matrix12d::Identity());
      break;
    }
  }
  return result;
}

}  // namespace isthmus::floam
