#include "server/placement/edge_information.h"

#include <algorithm>
#include <cmath>

#include "core/geometry/angles.h"
#include "server/placement/limits.h"

namespace isthmus::placement {
namespace {

double Weight(double sigma) { return sigma > 0 ? 1 / (sigma * sigma) : 0; }

}  // namespace

Matrix6d DriftInformation(const Node& before, const Node& node,
                          const pose_graph::DriftModel& drift) {
  const Pose T = before.T_odom_submap.Inverse() * node.T_odom_submap;
  const double steps = node.index - before.index;
  const double distance_m = std::max(T.translation().norm(), steps * node.travelled_m);
  const Matrix6d model = pose_graph::OdometryInformation(T, distance_m, RotationAngle(T), drift);
  return pose_graph::AddCovariance(model, steps * node.drift_covariance);
}

Matrix6d IsotropicInformation(double position_m, double rotation_rad) {
  Vector6d diagonal;
  diagonal << Eigen::Vector3d::Constant(Weight(position_m)),
      Eigen::Vector3d::Constant(Weight(rotation_rad));
  return diagonal.asDiagonal();
}

Matrix6d AnchorInformation(const Anchor& anchor) {
  Vector6d diagonal;
  const double xy = Weight(anchor.sigma_xy_m);
  diagonal << xy, xy, Weight(anchor.sigma_z_m),
      Eigen::Vector3d::Constant(Weight(anchor.sigma_deg * kRadPerDeg));
  return diagonal.asDiagonal();
}

bool IsUsable(const Pose& T_a_b, const Matrix6d& information) {
  return T_a_b.IsFinite() && T_a_b.translation().cwiseAbs().maxCoeff() < kMaxTranslationM &&
         pose_graph::SquareRootInformation(information).ok();
}

}  // namespace isthmus::placement
