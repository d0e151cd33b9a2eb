#include "server/pose_graph/information.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>

#include "absl/status/status.h"
#include "absl/strings/str_format.h"
#include "core/geometry/se3.h"

namespace isthmus::pose_graph {
namespace {

Matrix6d Inverse(const Matrix6d& symmetric) {
  const Matrix6d inverse = symmetric.ldlt().solve(Matrix6d::Identity());
  return 0.5 * (inverse + inverse.transpose());
}

}  // namespace

absl::StatusOr<Matrix6d> SquareRootInformation(const Matrix6d& information) {
  if (!information.allFinite()) return absl::InvalidArgumentError("information is not finite");
  const double scale = information.cwiseAbs().maxCoeff();
  const double asymmetry = (information - information.transpose()).cwiseAbs().maxCoeff();
  if (asymmetry > 1e-6 * scale) {
    return absl::InvalidArgumentError(
        absl::StrFormat("information is not symmetric: entries differ by %g", asymmetry));
  }
  const Matrix6d symmetric = 0.5 * (information + information.transpose());
  const Eigen::LLT<Matrix6d> cholesky(symmetric);
  if (cholesky.info() == Eigen::Success) return Matrix6d(cholesky.matrixU());
  const Eigen::SelfAdjointEigenSolver<Matrix6d> solver(symmetric);
  if (solver.info() != Eigen::Success) {
    return absl::InvalidArgumentError("information has no eigenvalues; check its numbers");
  }
  const double least = solver.eigenvalues().minCoeff();
  if (least < -1e-6 * scale) {
    return absl::InvalidArgumentError(
        absl::StrFormat("information has the negative eigenvalue %g; it must be the inverse of a "
                        "covariance, or zero where nothing is known",
                        least));
  }
  const Vector6d roots = solver.eigenvalues().cwiseMax(0).cwiseSqrt();
  return Matrix6d(roots.asDiagonal() * solver.eigenvectors().transpose());
}

Matrix6d OdometryInformation(const Pose& T_a_b, const DriftModel& drift) {
  return OdometryInformation(T_a_b, T_a_b.translation().norm(), RotationAngle(T_a_b), drift);
}

Matrix6d OdometryInformation(const Pose& T_a_b, double distance_m, double turn_rad,
                             const DriftModel& drift) {
  const double position = std::max(1e-6, drift.position_m + drift.position_per_m * distance_m);
  const double rotation = std::max(1e-6, drift.rotation_rad + drift.rotation_per_m * distance_m +
                                             drift.rotation_per_rad * turn_rad);
  Vector6d about_middle;
  about_middle << Eigen::Vector3d::Constant(1 / (position * position)),
      Eigen::Vector3d::Constant(1 / (rotation * rotation));
  // A twist about the origin of a, told about the middle of the way.
  const Matrix6d A = Adjoint(Pose(Eigen::Vector3d(-0.5 * T_a_b.translation())));
  return A.transpose() * about_middle.asDiagonal() * A;
}

Matrix6d AddCovariance(const Matrix6d& information, const Matrix6d& covariance) {
  if (covariance.isZero(0) || !SquareRootInformation(covariance).ok()) return information;
  const Matrix6d both = Inverse(Inverse(information) + 0.5 * (covariance + covariance.transpose()));
  return SquareRootInformation(both).ok() ? both : information;
}

}  // namespace isthmus::pose_graph
