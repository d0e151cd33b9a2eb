#include "server/matching/loops/loop_drift.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <queue>
#include <utility>

#include "core/geometry/se3.h"
#include "server/matching/loops/limits.h"
#include "server/matching/registration/limits.h"
#include "server/pose_graph/limits.h"

namespace isthmus::matching {
namespace {

Matrix6d Diagonal(double position, double rotation) {
  Vector6d diagonal;
  diagonal << Eigen::Vector3d::Constant(position * position),
      Eigen::Vector3d::Constant(rotation * rotation);
  return diagonal.asDiagonal();
}

Matrix6d Invert(const Matrix6d& matrix) { return matrix.ldlt().solve(Matrix6d::Identity()); }

// Covariance of a twist about the frame's origin, of what it does at `point`.
Matrix6d At(const Eigen::Vector3d& point, const Matrix6d& covariance) {
  Matrix6d J = Matrix6d::Identity();
  J.topRightCorner<3, 3>() = -Skew(point);
  return J * covariance * J.transpose();
}

// From one submap to another that is known from it, twist in the frame of the first.
struct Step {
  size_t to = 0;
  Pose T_from_to;
  Matrix6d covariance;

  Step Reversed(size_t from) const {
    const Matrix6d A = Adjoint(T_from_to.Inverse());
    return {from, T_from_to.Inverse(), A * covariance * A.transpose()};
  }
  double Variance() const {
    const Matrix6d there = At(T_from_to.translation(), covariance);
    return there.topLeftCorner<3, 3>().trace() +
           pose_graph::kLeverM * pose_graph::kLeverM * there.bottomRightCorner<3, 3>().trace();
  }
};

using Steps = std::vector<std::vector<Step>>;

Steps CollectSteps(const std::vector<std::shared_ptr<const Submap>>& submaps,
                   const std::vector<double>& path_lengths, const std::vector<LoopEdge>& edges,
                   const pose_graph::DriftModel& drift) {
  const size_t newest = submaps.size() - 1;
  Steps steps(newest + 1);
  const auto add = [&](size_t from, const Step& step) {
    steps[from].push_back(step);
    steps[step.to].push_back(step.Reversed(from));
  };
  for (size_t k = 0; k < newest; ++k) {
    const Pose T = submaps[k]->T_odom_submap.Inverse() * submaps[k + 1]->T_odom_submap;
    const double path_length =
        std::max(T.translation().norm(), path_lengths[k + 1] - path_lengths[k]);
    const Matrix6d information =
        pose_graph::OdometryInformation(T, path_length, RotationAngle(T), drift);
    add(k, {k + 1, T, Invert(information) + submaps[k + 1]->drift_covariance});
  }
  for (const LoopEdge& edge : edges) {
    if (edge.a > newest || edge.b > newest) continue;
    add(edge.a, {edge.b, edge.T_a_b,
                 Invert(edge.information + kLeastLoopInformation * Matrix6d::Identity()) +
                     Diagonal(kMinSigmaM, kMinSigmaM / pose_graph::kLeverM)});
  }
  return steps;
}

}  // namespace

double KnownPose::PositionSigma(const Eigen::Vector3d& point) const {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(
      At(point, covariance).topLeftCorner<3, 3>(), Eigen::EigenvaluesOnly);
  return std::sqrt(std::max(0.0, solver.eigenvalues()[2]));
}

double KnownPose::RotationSigma() const {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(covariance.bottomRightCorner<3, 3>(),
                                                              Eigen::EigenvaluesOnly);
  return std::sqrt(std::max(0.0, solver.eigenvalues()[2]));
}

double KnownPose::Chi2(const Pose& true_T_new_old, const Eigen::Vector3d& point, double slack_m,
                       double slack_rad) const {
  const Matrix6d C = covariance + At(-point, Diagonal(slack_m, slack_rad));
  const Vector6d error = Log(true_T_new_old * T_new_old.Inverse());
  return error.dot(C.ldlt().solve(error));
}

std::vector<KnownPose> LookBack(const std::vector<std::shared_ptr<const Submap>>& submaps,
                                const std::vector<double>& path_lengths,
                                const std::vector<LoopEdge>& edges,
                                const pose_graph::DriftModel& drift) {
  if (submaps.empty()) return {};
  const size_t newest = submaps.size() - 1;
  const Steps steps = CollectSteps(submaps, path_lengths, edges, drift);
  std::vector<KnownPose> known(newest + 1);
  std::vector<double> variance(newest + 1, std::numeric_limits<double>::infinity());
  using Entry = std::pair<double, size_t>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
  variance[newest] = 0;
  open.emplace(0, newest);
  while (!open.empty()) {
    const auto [so_far, from] = open.top();
    open.pop();
    if (so_far > variance[from]) continue;
    for (const Step& step : steps[from]) {
      // Below zero by rounding it would lead round for ever, and so would one that is no number.
      const double there = so_far + std::max(step.Variance(), 0.0);
      if (!(there < variance[step.to])) continue;
      variance[step.to] = there;
      const Matrix6d A = Adjoint(known[from].T_new_old);
      known[step.to] = {known[from].T_new_old * step.T_from_to,
                        known[from].covariance + A * step.covariance * A.transpose()};
      open.emplace(there, step.to);
    }
  }
  known.pop_back();
  return known;
}

}  // namespace isthmus::matching
