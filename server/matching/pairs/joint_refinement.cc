#include "server/matching/pairs/joint_refinement.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "server/matching/pairs/limits.h"
#include "server/matching/pairs/odom_transform.h"
#include "server/matching/pairs/own_edges.h"
#include "server/matching/pairs/submap_alignment.h"
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

Range Touched(const std::vector<SubmapEdge>& edges, uint32_t SubmapEdge::*side) {
  Range range{edges.front().*side, edges.front().*side};
  for (const SubmapEdge& edge : edges) {
    range.first = std::min<size_t>(range.first, edge.*side);
    range.last = std::max<size_t>(range.last, edge.*side);
  }
  return range;
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

struct Side {
  explicit Side(const PreparedMap& map) : submaps(map.submaps()), own(map) {}
  const PreparedSubmaps& submaps;
  const OwnEdges own;
};

// Submap poses that agree best with the edges and what both sessions know of themselves; true when
// found. Edges that the rest contradicts are dropped.
bool Solve(const Side& a, const Side& b, JointRefinement* joint) {
  const Range in_a = Close(a.own, Touched(joint->edges, &SubmapEdge::submap_a));
  const Range in_b = Close(b.own, Touched(joint->edges, &SubmapEdge::submap_b));
  const int first_b = static_cast<int>(in_a.count());
  pose_graph::Problem problem;
  for (size_t i = in_a.first; i <= in_a.last; ++i) problem.poses.push_back(joint->poses.a[i]);
  for (size_t j = in_b.first; j <= in_b.last; ++j) problem.poses.push_back(joint->poses.b[j]);
  problem.fixed = {0};
  double alone = AddOwnEdges(a.own, in_a, 0, &problem.edges);
  alone += AddOwnEdges(b.own, in_b, first_b, &problem.edges);
  const size_t steps = in_a.count() + in_b.count() - 2;
  const size_t own = problem.edges.size();
  for (const SubmapEdge& edge : joint->edges) {
    problem.edges.push_back({static_cast<int>(edge.submap_a - in_a.first),
                             first_b + static_cast<int>(edge.submap_b - in_b.first), edge.T_a_b,
                             edge.information, true});
  }
  const auto solved = pose_graph::Optimize(problem);
  if (!solved.ok()) return false;
  problem.poses = solved->poses;
  std::vector<SubmapEdge> kept;
  for (size_t k = own; k < problem.edges.size(); ++k) {
    if (solved->edge_weights[k] > 0.5) kept.push_back(joint->edges[k - own]);
  }
  if (kept.empty()) return false;
  joint->edges = std::move(kept);
  double chi2 = 0;
  for (size_t k = 0; k < own; ++k) chi2 += pose_graph::Chi2(problem, problem.edges[k]);
  chi2 = std::max(0.0, chi2 - alone);
  joint->odometry_residual = steps ? std::sqrt(chi2 / (6 * static_cast<double>(steps))) : 0;
  for (size_t i = in_a.first; i <= in_a.last; ++i) {
    joint->poses.a[i] = problem.poses[i - in_a.first];
  }
  for (size_t j = in_b.first; j <= in_b.last; ++j) {
    joint->poses.b[j] = problem.poses[in_a.count() + j - in_b.first];
  }
  Follow(a.submaps, in_a, &joint->poses.a);
  Follow(b.submaps, in_b, &joint->poses.b);
  return true;
}

}  // namespace

bool RefineJointly(const PreparedMap& map_a, const PreparedMap& map_b, double gate_m,
                   size_t first_a, size_t first_b, JointRefinement* joint) {
  const Side a(map_a), b(map_b);
  JointRefinement refined = *joint;
  const std::vector<SubmapEdge> old_edges =
      first_a == 0 && first_b == 0 ? std::vector<SubmapEdge>() : joint->edges;
  // Twice: from where they lie at first, and from where the others have moved them.
  for (const double gate : {gate_m, 0.5 * gate_m}) {
    refined.edges = old_edges;
    const std::vector<SubmapEdge> fresh = Align(
        a.submaps, b.submaps, FindPartners(a.submaps, b.submaps, refined.poses, first_a, first_b),
        refined.poses, gate);
    refined.edges.insert(refined.edges.end(), fresh.begin(), fresh.end());
    if (refined.edges.empty() || !Solve(a, b, &refined)) return false;
  }
  const std::optional<Pose> T_a_b = FitRigid(
      FramePoses::AsMatched(map_a.session_map(), map_b.session_map()), refined.edges, joint->T_a_b);
  if (!T_a_b) return false;
  refined.T_a_b = *T_a_b;
  *joint = std::move(refined);
  return true;
}

}  // namespace isthmus::matching
