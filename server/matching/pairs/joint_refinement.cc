#include "server/matching/pairs/joint_refinement.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "core/geometry/se3.h"
#include "server/matching/pairs/limits.h"
#include "server/matching/pairs/submap_alignment.h"
#include "server/pose_graph/information.h"
#include "server/pose_graph/optimize.h"

namespace isthmus::matching {
namespace {

using IndexPair = std::pair<size_t, size_t>;

// Nearest first, of every submap that has partners at all; a bounded number for each.
std::vector<IndexPair> FindPartners(const PreparedSubmaps& a, const PreparedSubmaps& b,
                                    const MapPoses& poses, size_t first_a, size_t first_b) {
  std::vector<IndexPair> pairs;
  std::vector<std::pair<double, size_t>> near;
  for (size_t j = 0; j < b.size(); ++j) {
    near.clear();
    const Eigen::Vector3d middle = poses.b[j] * b[j]->center();
    for (size_t i = j < first_b ? first_a : 0; i < a.size(); ++i) {
      const double apart = (poses.a[i] * a[i]->center() - middle).norm();
      if (apart < kMaxPartnersApart * (a[i]->radius_m() + b[j]->radius_m()))
        near.emplace_back(apart, i);
    }
    const size_t count = std::min(kPartners, near.size());
    std::partial_sort(near.begin(), near.begin() + static_cast<std::ptrdiff_t>(count), near.end());
    for (size_t k = 0; k < count; ++k) pairs.emplace_back(near[k].second, j);
  }
  return pairs;
}

std::vector<SubmapEdge> Align(const PreparedSubmaps& a, const PreparedSubmaps& b,
                              const std::vector<IndexPair>& pairs, const MapPoses& poses,
                              double gate_m) {
  std::vector<SubmapEdge> edges;
  for (const auto& [i, j] : pairs) {
    const Pose guess = poses.a[i].Inverse() * poses.b[j];
    const std::optional<SubmapAlignment> found = AlignSubmaps(*a[i], *b[j], guess, gate_m);
    if (!found) continue;
    edges.push_back(
        {static_cast<uint32_t>(i), static_cast<uint32_t>(j), found->T_a_b, found->information});
  }
  return edges;
}

// The submaps between the first and the last that an edge touches; the others follow them.
struct Range {
  size_t first = 0, last = 0;
  size_t count() const { return last - first + 1; }
};

Range Touched(const std::vector<SubmapEdge>& edges, uint32_t SubmapEdge::*side) {
  Range range{edges.front().*side, edges.front().*side};
  for (const SubmapEdge& edge : edges) {
    range.first = std::min<size_t>(range.first, edge.*side);
    range.last = std::max<size_t>(range.last, edge.*side);
  }
  return range;
}

void AddOdometry(const PreparedSubmaps& submaps, const Range& range, int first_node,
                 std::vector<pose_graph::Edge>* edges) {
  for (size_t k = range.first; k < range.last; ++k) {
    const int node = first_node + static_cast<int>(k - range.first);
    const Pose T =
        submaps[k]->submap().T_odom_submap.Inverse() * submaps[k + 1]->submap().T_odom_submap;
    edges->push_back({node, node + 1, T, pose_graph::OdometryInformation(T), false});
  }
}

// Moves the submaps outside of the range rigidly with its ends.
void Follow(const PreparedSubmaps& submaps, const Range& range, std::vector<Pose>* poses) {
  const auto carry = [&](size_t from, size_t to) {
    (*poses)[to] = (*poses)[from] * submaps[from]->submap().T_odom_submap.Inverse() *
                   submaps[to]->submap().T_odom_submap;
  };
  for (size_t k = 0; k < range.first; ++k) carry(range.first, k);
  for (size_t k = range.last + 1; k < submaps.size(); ++k) carry(range.last, k);
}

// Submap poses that agree best with the edges and both odometries; true when found. Edges that the
// rest contradicts are dropped.
bool Solve(const PreparedSubmaps& a, const PreparedSubmaps& b, JointRefinement* joint) {
  const Range in_a = Touched(joint->edges, &SubmapEdge::submap_a);
  const Range in_b = Touched(joint->edges, &SubmapEdge::submap_b);
  const int first_b = static_cast<int>(in_a.count());
  pose_graph::Problem problem;
  for (size_t i = in_a.first; i <= in_a.last; ++i) problem.poses.push_back(joint->poses.a[i]);
  for (size_t j = in_b.first; j <= in_b.last; ++j) problem.poses.push_back(joint->poses.b[j]);
  problem.fixed = {0};
  AddOdometry(a, in_a, 0, &problem.edges);
  AddOdometry(b, in_b, first_b, &problem.edges);
  const size_t odometry = problem.edges.size();
  for (const SubmapEdge& edge : joint->edges) {
    problem.edges.push_back({static_cast<int>(edge.submap_a - in_a.first),
                             first_b + static_cast<int>(edge.submap_b - in_b.first), edge.T_a_b,
                             edge.information, true});
  }
  const auto solved = pose_graph::Optimize(problem);
  if (!solved.ok()) return false;
  problem.poses = solved->poses;
  std::vector<SubmapEdge> kept;
  for (size_t k = odometry; k < problem.edges.size(); ++k) {
    if (solved->edge_weights[k] > 0.5) kept.push_back(joint->edges[k - odometry]);
  }
  if (kept.empty()) return false;
  joint->edges = std::move(kept);
  double chi2 = 0;
  for (size_t k = 0; k < odometry; ++k) chi2 += pose_graph::Chi2(problem, problem.edges[k]);
  joint->odometry_residual = odometry ? std::sqrt(chi2 / (6 * static_cast<double>(odometry))) : 0;
  for (size_t i = in_a.first; i <= in_a.last; ++i) {
    joint->poses.a[i] = problem.poses[i - in_a.first];
  }
  for (size_t j = in_b.first; j <= in_b.last; ++j) {
    joint->poses.b[j] = problem.poses[in_a.count() + j - in_b.first];
  }
  Follow(a, in_a, &joint->poses.a);
  Follow(b, in_b, &joint->poses.b);
  return true;
}

// The rigid transform between the odom frames that the edges agree on best.
std::optional<Pose> FitRigid(const PreparedSubmaps& a, const PreparedSubmaps& b,
                             const std::vector<SubmapEdge>& edges, const Pose& guess) {
  pose_graph::Problem problem;
  problem.poses = {Pose(), guess};
  problem.fixed = {0};
  for (const SubmapEdge& edge : edges) {
    const Pose& T_odom_a = a[edge.submap_a]->submap().T_odom_submap;
    const Pose& T_odom_b = b[edge.submap_b]->submap().T_odom_submap;
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

}  // namespace

bool RefineJointly(const PreparedSubmaps& a, const PreparedSubmaps& b, double gate_m,
                   size_t first_a, size_t first_b, JointRefinement* joint) {
  JointRefinement refined = *joint;
  const std::vector<SubmapEdge> old_edges =
      first_a == 0 && first_b == 0 ? std::vector<SubmapEdge>() : joint->edges;
  // Twice: from where they lie at first, and from where the others have moved them.
  for (const double gate : {gate_m, 0.5 * gate_m}) {
    refined.edges = old_edges;
    const std::vector<SubmapEdge> fresh =
        Align(a, b, FindPartners(a, b, refined.poses, first_a, first_b), refined.poses, gate);
    refined.edges.insert(refined.edges.end(), fresh.begin(), fresh.end());
    if (refined.edges.empty() || !Solve(a, b, &refined)) return false;
  }
  const std::optional<Pose> T_a_b = FitRigid(a, b, refined.edges, joint->T_a_b);
  if (!T_a_b) return false;
  refined.T_a_b = *T_a_b;
  *joint = std::move(refined);
  return true;
}

}  // namespace isthmus::matching
