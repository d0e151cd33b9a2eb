#include "server/matching/pairs/odom_transform.h"

#include <algorithm>
#include <limits>

#include "core/geometry/se3.h"
#include "server/pose_graph/optimize.h"

namespace isthmus::matching {
namespace {

std::vector<Pose> PosesOf(const SessionMap& map) {
  std::vector<Pose> poses;
  for (const auto& submap : map.submaps) poses.push_back(submap->T_odom_submap);
  return poses;
}

std::vector<Pose> OdometryOf(const PreparedMap& map) {
  return map.shape() ? map.shape()->odometry : PosesOf(map.session_map());
}

}  // namespace

FramePoses FramePoses::AsMatched(const SessionMap& a, const SessionMap& b) {
  return {PosesOf(a), PosesOf(b)};
}

FramePoses FramePoses::ByOdometry(const PreparedMap& a, const PreparedMap& b) {
  return {OdometryOf(a), OdometryOf(b)};
}

std::optional<Pose> FitRigid(const FramePoses& poses, const std::vector<SubmapEdge>& edges,
                             const Pose& guess) {
  if (edges.empty()) return std::nullopt;
  pose_graph::Problem problem;
  problem.poses = {Pose(), guess};
  problem.fixed = {0};
  for (const SubmapEdge& edge : edges) {
    const Pose& T_odom_a = poses.a[edge.submap_a];
    const Pose& T_odom_b = poses.b[edge.submap_b];
    // A twist in a's odom frame, seen from the submap of a.
    const Matrix6d J = Adjoint(T_odom_a.Inverse());
    const Matrix6d information = J.transpose() * edge.information * J;
    problem.edges.push_back({0, 1, T_odom_a * edge.T_a_b * T_odom_b.Inverse(),
                             0.5 * (information + information.transpose()), false});
  }
  const auto solved = pose_graph::Optimize(problem);
  if (!solved.ok()) return std::nullopt;
  return solved->poses[1];
}

Pose Reframe(const FramePoses& from, const FramePoses& to, const std::vector<SubmapEdge>& edges,
             const Pose& T_a_b) {
  size_t near_a = 0, near_b = 0;
  double least = std::numeric_limits<double>::infinity();
  const size_t count_a = std::min(from.a.size(), to.a.size());
  const size_t count_b = std::min(from.b.size(), to.b.size());
  if (count_a == 0 || count_b == 0) return T_a_b;
  for (size_t j = 0; j < count_b; ++j) {
    const Eigen::Vector3d at = T_a_b * from.b[j].translation();
    for (size_t i = 0; i < count_a; ++i) {
      const double apart = (from.a[i].translation() - at).squaredNorm();
      if (apart >= least) continue;
      least = apart;
      near_a = i;
      near_b = j;
    }
  }
  const Pose T_near = from.a[near_a].Inverse() * T_a_b * from.b[near_b];
  const Pose guess = to.a[near_a] * T_near * to.b[near_b].Inverse();
  return FitRigid(to, edges, guess).value_or(guess);
}

}  // namespace isthmus::matching
