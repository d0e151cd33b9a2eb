// What matches say of a pose, without what their noise says, and joined with what was known before.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/pose.h"
#include "floam/normal_equations.h"

namespace isthmus::floam {

// What is known of the pose before matching: it is T_odom_sensor Exp(d), with this covariance of d.
struct PosePrior {
  Pose T_odom_sensor;
  Matrix6d covariance = Matrix6d::Identity();
};

// The expected information that the noise of normals alone would bring. The normal n of a plane
// fitted to few or rough points is off by a small e, orthogonal to it, of variance s per axis; then
// E[(n + e)(n + e)^T] = n n^T + s (I - n n^T): along directions in which no plane holds it looks as
// if it were held, and an estimate that believes it stands still. After J. Hatleskog, K. Alexis,
// "Probabilistic Degeneracy Detection for Point-to-Plane Error Minimization", RA-L 2024, section
// III, where the noise of points and normals is carried into the Hessian.
class NormalNoise {
 public:
  // A match of weight w at q, `offset` away from the middle of the plane's points, its normal n
  // with variance s per axis; all in the sensor frame.
  void Add(const Eigen::Vector3d& q, const Eigen::Vector3d& offset, const Vector6d& jacobian,
           double weight, double variance) {
    const double ws = weight * variance;
    Vector6d lever;
    lever << offset, q.cross(offset);
    gradient_.noalias() += ws * (lever - jacobian.head<3>().dot(offset) * jacobian);
    sum_ += ws;
    first_ += ws * q;
    second_.noalias() += ws * q * q.transpose();
    along_.noalias() += ws * jacobian * jacobian.transpose();
  }
  // Sum over the matches of w s B (I - n n^T) B^T with B = [I; [q]x].
  Matrix6d Information() const;
  // Sum of w s B (I - n n^T) offset: where it draws the estimate to.
  const Vector6d& Gradient() const { return gradient_; }

 private:
  Vector6d gradient_ = Vector6d::Zero();
  double sum_ = 0;
  Eigen::Vector3d first_ = Eigen::Vector3d::Zero();
  Eigen::Matrix3d second_ = Eigen::Matrix3d::Zero();
  Matrix6d along_ = Matrix6d::Zero();
};

// One match: derivative of its distance by the pose, weight, and where the point is, from where the
// pose turns.
struct MatchRow {
  Vector6d jacobian;
  double weight = 0;
  Eigen::Vector3d q = Eigen::Vector3d::Zero();
};

// The minimum of matches, prior on the pose and prior on the twist together.
struct JointEstimate {
  Vector12d step = Vector12d::Zero();        // Of [pose; twist] from where they are.
  Matrix12d covariance = Matrix12d::Zero();  // After it.
  // Of the matches alone about the pose, of little information only the part that is plain: what
  // is to be said to be known.
  Matrix6d match_information = Matrix6d::Zero();
};

// `H`, `g`: information and gradient over [pose; twist] of the matches with all that is known of
// the twist (which must make the twist's block regular); `noise` and `rows` of these matches;
// `offset` = Log(prior^-1 pose). In the eigenbasis of what the matches say, measured in the prior's
// standard deviations, what their noise says is taken off, and of what is little the share counts
// that does not hang on a few matches: a handful of points far away, or on something that moves,
// must not decide where the sensor is. The estimate uses that; said to be known is what matches
// tell whose normals lie along the motion (S. Tuna et al., "X-ICP", T-RO 2024, section V, likewise
// counts matches and leaves out those nearly at right angles).
JointEstimate Solve(const Matrix12d& H, const Vector12d& g, const NormalNoise& noise,
                    const std::vector<MatchRow>& rows, const Matrix6d& prior,
                    const Vector6d& offset);

}  // namespace isthmus::floam
