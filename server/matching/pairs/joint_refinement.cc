#include "server/matching/pairs/joint_refinement.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <utility>

#include "server/matching/pairs/limits.h"
#include "server/matching/pairs/odom_transform.h"
#include "server/matching/pairs/own_edges.h"
#include "server/matching/pairs/submap_alignment.h"
#include "server/matching/prepared/limits.h"
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

// The edges of other pairs of submaps than those that are tied.
std::vector<SubmapEdge> BesideTies(const std::vector<SubmapEdge>& edges,
                                   const std::vector<SubmapEdge>& ties) {
  std::set<IndexPair> tied;
  for (const SubmapEdge& tie : ties) tied.emplace(tie.submap_a, tie.submap_b);
  std::vector<SubmapEdge> beside;
  for (const SubmapEdge& edge : edges) {
    if (!tied.contains({edge.submap_a, edge.submap_b})) beside.push_back(edge);
  }
  return beside;
}

std::vector<SubmapEdge> Joined(std::vector<SubmapEdge> edges, const std::vector<SubmapEdge>& more) {
  edges.insert(edges.end(), more.begin(), more.end());
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
// found. Edges that the rest contradicts are dropped; ties never are.
bool Solve(const Side& a, const Side& b, JointRefinement* joint) {
  const std::vector<SubmapEdge> all = Joined(joint->edges, joint->ties);
  const Range in_a = Close(a.own, Touched(all, &SubmapEdge::submap_a));
  const Range in_b = Close(b.own, Touched(all, &SubmapEdge::submap_b));
  const int first_b = static_cast<int>(in_a.count());
  pose_graph::Problem problem;
  for (size_t i = in_a.first; i <= in_a.last; ++i) problem.poses.push_back(joint->poses.a[i]);
  for (size_t j = in_b.first; j <= in_b.last; ++j) problem.poses.push_back(joint->poses.b[j]);
  problem.fixed = {0};
  double alone = AddOwnEdges(a.own, in_a, 0, &problem.edges);
  alone += AddOwnEdges(b.own, in_b, first_b, &problem.edges);
  const size_t steps = in_a.count() + in_b.count() - 2;
  const size_t own = problem.edges.size();
  if (!joint->ties.empty()) {
    // They show that odometry errs more than most.
    for (pose_graph::Edge& edge : problem.edges) edge.information /= kMaxDriftScale;
    alone /= kMaxDriftScale;
  }
  for (size_t k = 0; k < all.size(); ++k) {
    const SubmapEdge& edge = all[k];
    problem.edges.push_back({static_cast<int>(edge.submap_a - in_a.first),
                             first_b + static_cast<int>(edge.submap_b - in_b.first), edge.T_a_b,
                             edge.information, k < joint->edges.size()});
  }
  const auto solved = pose_graph::Optimize(problem);
  if (!solved.ok()) return false;
  problem.poses = solved->poses;
  std::vector<SubmapEdge> kept;
  for (size_t k = 0; k < joint->edges.size(); ++k) {
    if (solved->edge_weights[own + k] > 0.5) kept.push_back(joint->edges[k]);
  }
  if (kept.empty() && joint->ties.empty()) return false;
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

// Begins where the ties bend the ways: no rigid fit has both ends of a drifted way near enough to
// align them. The stretch where the maps were joined counts as the ties do, or these would tear it.
bool FollowTies(const Side& a, const Side& b, JointRefinement* joint) {
  JointRefinement tied = *joint;
  tied.edges.clear();
  tied.ties = Joined(LongestStretch(BesideTies(joint->edges, joint->ties)), joint->ties);
  if (!Solve(a, b, &tied)) return false;
  joint->poses = std::move(tied.poses);
  return true;
}

}  // namespace

std::vector<SubmapEdge> LongestStretch(const std::vector<SubmapEdge>& edges) {
  const auto are_near = [](const SubmapEdge& x, const SubmapEdge& y) {
    const auto apart = [](uint32_t i, uint32_t j) { return i < j ? j - i : i - j; };
    return apart(x.submap_a, y.submap_a) <= kStretchSubmaps &&
           apart(x.submap_b, y.submap_b) <= kStretchSubmaps;
  };
  std::vector<SubmapEdge> left = edges, longest;
  while (left.size() > longest.size()) {
    std::vector<SubmapEdge> stretch = {left.front()};
    left.erase(left.begin());
    for (size_t k = 0; k < stretch.size(); ++k) {
      const auto next = std::stable_partition(
          left.begin(), left.end(),
          [&](const SubmapEdge& edge) { return !are_near(edge, stretch[k]); });
      stretch.insert(stretch.end(), next, left.end());
      left.erase(next, left.end());
    }
    if (stretch.size() > longest.size()) longest = std::move(stretch);
  }
  return longest;
}

bool RefineJointly(const PreparedMap& map_a, const PreparedMap& map_b, double gate_m,
                   size_t first_a, size_t first_b, JointRefinement* joint) {
  const Side a(map_a), b(map_b);
  JointRefinement refined = *joint;
  const bool anew = first_a == 0 && first_b == 0;
  const std::vector<SubmapEdge> old_edges =
      anew ? std::vector<SubmapEdge>() : BesideTies(joint->edges, joint->ties);
  if (anew && !refined.ties.empty() && !FollowTies(a, b, &refined)) return false;
  // Twice: from where they lie at first, and from where the others have moved them.
  for (const double gate : {gate_m, 0.5 * gate_m}) {
    const std::vector<SubmapEdge> fresh = Align(
        a.submaps, b.submaps, FindPartners(a.submaps, b.submaps, refined.poses, first_a, first_b),
        refined.poses, gate);
    refined.edges = Joined(old_edges, BesideTies(fresh, refined.ties));
    if (refined.edges.empty() || !Solve(a, b, &refined)) return false;
  }
  refined.edges = Joined(std::move(refined.edges), refined.ties);
  const std::optional<Pose> T_a_b =
      FitRigid(FramePoses::AsMatched(map_a.session_map(), map_b.session_map()),
               LongestStretch(refined.edges), joint->T_a_b);
  if (!T_a_b) return false;
  refined.T_a_b = *T_a_b;
  *joint = std::move(refined);
  return true;
}

}  // namespace isthmus::matching
