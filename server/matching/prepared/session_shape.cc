#include "server/matching/prepared/session_shape.h"

#include <Eigen/Geometry>
#include <algorithm>

#include "server/matching/prepared/limits.h"
#include "server/pose_graph/limits.h"

namespace isthmus::matching {
namespace {

using Corners = Eigen::Matrix<double, 3, Eigen::Dynamic>;
Corners CornersOf(const std::vector<Pose>& poses) {
  Corners corners(3, 4 * static_cast<Eigen::Index>(poses.size()));
  Eigen::Index i = 0;
  for (const Pose& pose : poses) {
    const Eigen::Matrix3d axes = pose_graph::kLeverM * pose.RotationMatrix();
    corners.col(i) = pose.translation();
    corners.middleCols<3>(i + 1) = axes.colwise() + pose.translation();
    i += 4;
  }
  return corners;
}

}  // namespace

std::vector<pose_graph::Edge> OdometrySteps(const SubmapList& submaps,
                                            const pose_graph::DriftModel& drift) {
  std::vector<pose_graph::Edge> steps;
  for (size_t k = 0; k + 1 < submaps.size(); ++k) {
    const Submap &from = *submaps[k], &to = *submaps[k + 1];
    const Pose T = from.T_odom_submap.Inverse() * to.T_odom_submap;
    // A covariance is since the submap before, which may have been retired.
    const bool next = to.id.index == from.id.index + 1;
    const Matrix6d own = next ? to.drift_covariance : Matrix6d(Matrix6d::Zero());
    const int node = static_cast<int>(k);
    steps.push_back({node, node + 1, T,
                     pose_graph::AddCovariance(pose_graph::OdometryInformation(T, drift), own),
                     false});
  }
  return steps;
}

std::shared_ptr<const Submap> LyingAt(const std::shared_ptr<const Submap>& submap,
                                      const Pose& T_odom_submap) {
  if (submap->T_odom_submap.Matrix() == T_odom_submap.Matrix()) return submap;
  auto moved = std::make_shared<Submap>(*submap);
  moved->T_odom_submap = T_odom_submap;
  return moved;
}

double DriftScale(const pose_graph::Problem& problem, const std::vector<pose_graph::Edge>& edges,
                  size_t steps) {
  double chi2 = 0;
  for (const pose_graph::Edge& edge : edges) chi2 += pose_graph::Chi2(problem, edge);
  const auto freedoms = static_cast<double>(6 * (edges.size() - steps));
  return freedoms > 0 ? std::clamp(chi2 / freedoms, 1.0, kMaxDriftScale) : 1;
}

ShapeFit FitShape(const std::vector<Pose>& from, const std::vector<Pose>& to) {
  const Corners from_corners = CornersOf(from), to_corners = CornersOf(to);
  if (from.empty() || from_corners == to_corners) return {};
  ShapeFit fit;
  fit.T_to_from = Pose::FromMatrix(Eigen::umeyama(from_corners, to_corners, false));
  const Corners moved =
      (fit.T_to_from.RotationMatrix() * from_corners).colwise() + fit.T_to_from.translation();
  fit.farthest_m = (moved - to_corners).colwise().norm().maxCoeff();
  return fit;
}

}  // namespace isthmus::matching
