#include "server/placement/anchor_fit.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "server/placement/limits.h"

namespace isthmus::placement {
namespace {

// An anchor and the node as it lies now.
struct Tie {
  Pose T_map_node, T_anchor;
  Eigen::Vector3d known;  // 1 for each axis along which the position is known, else 0.
  bool attitude = false;
};

Tie MakeTie(const pose_graph::Problem& problem, const pose_graph::Anchor& anchor) {
  Tie tie{problem.poses[static_cast<size_t>(anchor.node)], anchor.T_map_node, {}};
  const Vector6d diagonal = anchor.information.diagonal();
  tie.known = (diagonal.head<3>().array() > 0).cast<double>();
  tie.attitude = (diagonal.tail<3>().array() > 0).all();
  return tie;
}

// The translation that remains after the rotation; none along unknown axes.
Eigen::Vector3d Shift(const Tie& tie, const Eigen::Quaterniond& R) {
  const Eigen::Vector3d& p = tie.T_map_node.translation();
  const Eigen::Vector3d target = p + tie.known.cwiseProduct(tie.T_anchor.translation() - p);
  return target - R * p;
}

Pose FromOne(const Tie& tie) {
  Eigen::Quaterniond R = Eigen::Quaterniond::Identity();
  if (tie.attitude) R = tie.T_anchor.rotation() * tie.T_map_node.rotation().inverse();
  return Pose(R, Shift(tie, R));
}

bool HasPlan(const Tie& tie) { return tie.known.x() > 0 && tie.known.y() > 0; }

Pose FromTwo(const Tie& a, const Tie& b) {
  const Eigen::Vector3d from = b.T_map_node.translation() - a.T_map_node.translation();
  const Eigen::Vector3d to = b.T_anchor.translation() - a.T_anchor.translation();
  const double yaw = std::atan2(to.y(), to.x()) - std::atan2(from.y(), from.x());
  const Eigen::Quaterniond R(Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()));
  return Pose(R, 0.5 * (Shift(a, R) + Shift(b, R)));
}

double Misfit(const std::vector<Tie>& ties, const Pose& T) {
  double sum = 0;
  for (const Tie& tie : ties) {
    const Eigen::Vector3d gap = T * tie.T_map_node.translation() - tie.T_anchor.translation();
    sum += tie.known.cwiseProduct(gap).norm();
  }
  return sum;
}

}  // namespace

Pose FitToAnchors(const pose_graph::Problem& problem) {
  std::vector<Tie> ties;
  for (const pose_graph::Anchor& anchor : problem.anchors) ties.push_back(MakeTie(problem, anchor));
  std::vector<Pose> candidates;
  const bool attitude =
      std::any_of(ties.begin(), ties.end(), [](const Tie& tie) { return tie.attitude; });
  // Pairs of far-apart ones among at most so many, spread over all.
  const size_t stride = ties.size() / kMaxAnchorsInPairs + 1;
  for (size_t i = 0; i < ties.size(); i += stride) {
    if (ties[i].attitude == attitude) candidates.push_back(FromOne(ties[i]));
    for (size_t j = i + stride; j < ties.size() && !attitude; j += stride) {
      if (!HasPlan(ties[i]) || !HasPlan(ties[j])) continue;
      const Eigen::Vector3d apart =
          ties[i].T_map_node.translation() - ties[j].T_map_node.translation();
      if (apart.head<2>().norm() > kMinBaselineM) {
        candidates.push_back(FromTwo(ties[i], ties[j]));
      }
    }
  }
  Pose best;
  double least = std::numeric_limits<double>::infinity();
  for (const Pose& T : candidates) {
    const double misfit = Misfit(ties, T);
    if (misfit >= least) continue;
    least = misfit;
    best = T;
  }
  return best;
}

void KeepUpright(const Input& input, Graph* graph) {
  pose_graph::Problem& problem = graph->problem;
  if (problem.anchors.empty()) return;
  for (const pose_graph::Anchor& anchor : problem.anchors) {
    if (anchor.information.diagonal().tail<3>().maxCoeff() > 0) return;
  }
  const size_t gauge = static_cast<size_t>(graph->gauge);
  for (const GraphSession& session : graph->sessions) {
    const int k = graph->gauge - session.first_node;
    if (k < 0 || k >= session.node_count) continue;
    const Pose& T_odom_node =
        input.sessions[session.session].nodes[static_cast<size_t>(k)].T_odom_submap;
    const double yaw = (problem.poses[gauge] * T_odom_node.Inverse()).Yaw();
    const Pose upright = Pose::FromXyzRpy(0, 0, 0, 0, 0, yaw) * T_odom_node;
    Matrix6d information = Matrix6d::Zero();
    information(3, 3) = information(4, 4) = 1 / (kVerticalRad * kVerticalRad);
    problem.anchors.push_back({graph->gauge,
                               Pose(upright.rotation(), problem.poses[gauge].translation()),
                               information, false});
  }
}

}  // namespace isthmus::placement
