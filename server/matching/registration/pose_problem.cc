#include "server/matching/registration/pose_problem.h"

#include <Eigen/Cholesky>
#include <algorithm>

#include "server/pose_graph/limits.h"

namespace isthmus::matching {

Pose MoveAbout(const Eigen::Vector3d& center, const Vector6d& twist, const Pose& T) {
  const Pose local(T.rotation(), T.translation() - center);
  const Pose moved = Exp(twist) * local;
  return Pose(moved.rotation(), moved.translation() + center);
}

NormalEquations Linearize(const std::vector<Correspondence>& pairs, const Pose& T_a_b,
                          const Eigen::Vector3d& center) {
  NormalEquations equations;
  const Eigen::Matrix3d R = T_a_b.RotationMatrix();
  const Eigen::Vector3d t = T_a_b.translation();
  for (const Correspondence& pair : pairs) {
    const Eigen::Vector3d p = R * pair.p_b + t;
    const Eigen::Vector3d d = pair.q_a - p;
    const Eigen::Vector3d Wd = pair.weight * d;
    const Eigen::Matrix3d S = Skew(p - center);
    const Eigen::Matrix3d WS = pair.weight * S;
    // With J = [-I, S]: J^T W J = [W, -WS; -S^T W, S^T W S], J^T W d = [-Wd; S^T Wd].
    equations.H.topLeftCorner<3, 3>() += pair.weight;
    equations.H.topRightCorner<3, 3>() -= WS;
    equations.H.bottomRightCorner<3, 3>().noalias() += S.transpose() * WS;
    equations.g.head<3>() -= Wd;
    equations.g.tail<3>().noalias() += S.transpose() * Wd;
    equations.cost += 0.5 * d.dot(Wd);
  }
  equations.H.bottomLeftCorner<3, 3>() = equations.H.topRightCorner<3, 3>().transpose();
  return equations;
}

bool IsSmallStep(const Vector6d& twist, double step_m) {
  return twist.head<3>().norm() < step_m && twist.tail<3>().norm() < step_m / pose_graph::kLeverM;
}

bool StepPose(const std::vector<Correspondence>& pairs, double damping, Pose* T_a_b,
              Vector6d* twist) {
  if (pairs.size() < 6) return false;
  Eigen::Vector3d center = Eigen::Vector3d::Zero();
  for (const Correspondence& pair : pairs) center += pair.q_a;
  center /= static_cast<double>(pairs.size());
  const NormalEquations equations = Linearize(pairs, *T_a_b, center);
  // The floor keeps a direction without any information solvable; it then gets no step.
  Matrix6d H = equations.H;
  const double floor = 1e-9 * std::max(H.diagonal().maxCoeff(), 1e-12);
  H.diagonal() += damping * equations.H.diagonal() + Vector6d::Constant(floor);
  const Vector6d xi = H.ldlt().solve(-equations.g);
  if (!xi.allFinite()) return false;
  const Pose moved = MoveAbout(center, xi, *T_a_b);
  if (!moved.IsFinite()) return false;
  *T_a_b = moved;
  *twist = xi;
  return true;
}

Matrix6d MoveInformationToOrigin(const Matrix6d& information, const Eigen::Vector3d& center) {
  // A twist about the centre is one about the origin with rho_0 = rho - phi x c = rho + [c]x phi,
  // so that the centre's twist is B times the origin's with B = [I, -[c]x; 0, I].
  Matrix6d B = Matrix6d::Identity();
  B.topRightCorner<3, 3>() = -Skew(center);
  return B.transpose() * information * B;
}

}  // namespace isthmus::matching
