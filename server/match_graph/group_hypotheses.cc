#include "server/match_graph/group_hypotheses.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>
#include <tuple>
#include <utility>

#include "core/union_find.h"

namespace isthmus::match_graph {
namespace {

void Append(const std::vector<Step>& more, std::vector<Step>* steps) {
  steps->insert(steps->end(), more.begin(), more.end());
}

void AppendPoints(const std::vector<Eigen::Vector3d>& more, std::vector<Eigen::Vector3d>* all) {
  all->insert(all->end(), more.begin(), more.end());
}

bool OfOnePair(const FrameConstraint& p, const FrameConstraint& q) {
  return p.from == q.from && p.to == q.to;
}

// Ties are left to which came first.
bool IsBetter(const FrameConstraint& p, const FrameConstraint& q) {
  return p.hypothesis->log_odds > q.hypothesis->log_odds;
}

// Fills the probabilities: one of the group hypotheses is right, or none of them. Group hypotheses
// whose middle belongs to a better one are that one over again.
void Weigh(std::vector<GroupHypothesis>* groups) {
  std::set<const Hypothesis*> taken;
  std::vector<GroupHypothesis> kept;
  double sum = 1;
  for (GroupHypothesis& group : *groups) {
    if (taken.contains(group.constraint.hypothesis)) continue;
    taken.insert(group.members.begin(), group.members.end());
    sum += std::exp(group.log_odds);
    kept.push_back(std::move(group));
  }
  for (GroupHypothesis& group : kept) group.probability = std::exp(group.log_odds) / sum;
  *groups = std::move(kept);
}

}  // namespace

FrameConstraint GroupHypotheses::MakeConstraint(const Hypothesis& h, uint32_t first) const {
  FrameConstraint constraint{&h, h.a, h.b, h.T_a_b, {}, h.ground_a, h.ground_b};
  if (rigid_groups_.FrameOf(h.a) != first) {
    std::swap(constraint.from, constraint.to);
    std::swap(constraint.ground, constraint.far_ground);
    constraint.T_from_to = h.T_a_b.Inverse();
  }
  const Pose &T_first = rigid_groups_.T_frame_odom(constraint.from),
             &T_second = rigid_groups_.T_frame_odom(constraint.to);
  constraint.T_first_second = T_first * constraint.T_from_to * T_second.Inverse();
  for (Eigen::Vector3d& p : constraint.ground) p = T_first * p;
  for (Eigen::Vector3d& p : constraint.far_ground) p = T_second * p;
  return constraint;
}

// There by one, back by the other.
std::vector<Step> GroupHypotheses::StepsBetween(const FrameConstraint& p,
                                                const FrameConstraint& q) const {
  std::vector<Step> steps = {{&evidence_.nodes[p.from], p.T_from_to}};
  Append(rigid_groups_.Path(p.to, q.to), &steps);
  steps.push_back({&evidence_.nodes[q.to], q.T_from_to.Inverse()});
  Append(rigid_groups_.Path(q.from, p.from), &steps);
  return steps;
}

double GroupHypotheses::MostDegrees() const {
  const auto most = static_cast<double>(evidence_.nodes.size());
  return options_.cycles.max_deg * std::sqrt(std::max(1.0, most / 3));
}

bool GroupHypotheses::MayClose(const FrameConstraint& xy, const FrameConstraint& yz,
                               const FrameConstraint& xz) const {
  // Frames are named by their first node, so that the second one of xy is the first of yz.
  const Pose left = xy.T_first_second * yz.T_first_second * xz.T_first_second.Inverse();
  return RotationAngle(left) * 180 / std::numbers::pi <= MostDegrees();
}

bool GroupHypotheses::Agree(const FrameConstraint& p, const FrameConstraint& q) const {
  // Most do not, by far.
  const double rad = RotationAngle(p.T_first_second.Inverse() * q.T_first_second);
  return rad * 180 / std::numbers::pi <= MostDegrees() &&
         GoRound(StepsBetween(p, q), options_.cycles).Agrees();
}

bool GroupHypotheses::IsContradicted(const FrameConstraint& constraint,
                                     const std::vector<const OpenPair*>& pairs) const {
  for (const OpenPair* pair : pairs) {
    for (const Hypothesis& h : pair->contradicted) {
      if (Agree(constraint, MakeConstraint(h, rigid_groups_.FrameOf(constraint.from)))) return true;
    }
  }
  return false;
}

GroupHypothesis GroupHypotheses::MakeGroup(const std::vector<FrameConstraint>& constraints,
                                           size_t center) const {
  std::vector<const FrameConstraint*> members = {&constraints[center]};
  for (const FrameConstraint& constraint : constraints) {
    if (OfOnePair(constraint, constraints[center]) || !Agree(constraints[center], constraint))
      continue;
    const auto known =
        std::find_if(members.begin(), members.end(),
                     [&](const FrameConstraint* other) { return OfOnePair(constraint, *other); });
    if (known == members.end()) {
      members.push_back(&constraint);
    } else if (IsBetter(constraint, **known)) {
      *known = &constraint;
    }
  }
  UnionFind places(members.size());
  for (size_t i = 0; i < members.size(); ++i) {
    for (size_t j = 0; j < i; ++j) {
      if (AreSameGround(members[i]->ground, members[j]->ground, options_.cycles) ||
          AreSameGround(members[i]->far_ground, members[j]->far_ground, options_.cycles)) {
        places.Unite(i, j);
      }
    }
  }
  GroupHypothesis group;
  group.constraint = constraints[center];
  std::map<size_t, double> best;  // Log odds by place: what rests on one is wrong together.
  for (size_t i = 0; i < members.size(); ++i) {
    const Hypothesis& h = *members[i]->hypothesis;
    group.members.push_back(&h);
    AppendPoints(members[i]->ground, &group.ground);
    AppendPoints(members[i]->far_ground, &group.far_ground);
    const auto [known, is_new] = best.emplace(places.Find(i), h.log_odds);
    known->second = std::max(known->second, h.log_odds);
  }
  std::vector<double> odds;
  for (const auto& [place, log_odds] : best) odds.push_back(log_odds);
  std::sort(odds.rbegin(), odds.rend());
  group.log_odds = odds.front();
  group.grounds = 1;
  for (size_t i = 1; i < odds.size(); ++i) {
    // Wrong by itself as a rule, but wrong in just this way it would be by chance.
    const double more = odds[i] - std::log(options_.chance);
    if (more <= 0) continue;
    group.log_odds += more;
    ++group.grounds;
  }
  return group;
}

std::vector<GroupHypothesis> GroupHypotheses::Between(
    uint32_t x, const std::vector<const OpenPair*>& pairs) const {
  std::vector<FrameConstraint> constraints;
  for (const OpenPair* pair : pairs) {
    for (const Hypothesis& h : pair->hypotheses) constraints.push_back(MakeConstraint(h, x));
  }
  std::stable_sort(constraints.begin(), constraints.end(), IsBetter);
  if (constraints.size() > options_.max_between) constraints.resize(options_.max_between);
  std::erase_if(constraints, [&](const FrameConstraint& constraint) {
    return IsContradicted(constraint, pairs);
  });
  std::vector<GroupHypothesis> groups;
  for (size_t i = 0; i < constraints.size(); ++i) groups.push_back(MakeGroup(constraints, i));
  std::stable_sort(groups.begin(), groups.end(),
                   [](const GroupHypothesis& l, const GroupHypothesis& r) {
                     return std::make_tuple(l.log_odds, l.constraint.hypothesis->log_odds) >
                            std::make_tuple(r.log_odds, r.constraint.hypothesis->log_odds);
                   });
  Weigh(&groups);
  return groups;
}

std::vector<Step> GroupHypotheses::StepsBack(const FrameConstraint& constraint,
                                             const Hypothesis& by) const {
  return StepsBetween(constraint, MakeConstraint(by, rigid_groups_.FrameOf(constraint.from)));
}

std::vector<Step> GroupHypotheses::StepsRound(const FrameConstraint& xy, const FrameConstraint& yz,
                                              const FrameConstraint& xz) const {
  std::vector<Step> steps = {{&evidence_.nodes[xy.from], xy.T_from_to}};
  Append(rigid_groups_.Path(xy.to, yz.from), &steps);
  steps.push_back({&evidence_.nodes[yz.from], yz.T_from_to});
  Append(rigid_groups_.Path(yz.to, xz.to), &steps);
  steps.push_back({&evidence_.nodes[xz.to], xz.T_from_to.Inverse()});
  Append(rigid_groups_.Path(xz.from, xy.from), &steps);
  return steps;
}

std::vector<Step> GroupHypotheses::StepsBack(const Hypothesis& h) const {
  std::vector<Step> steps = {{&evidence_.nodes[h.a], h.T_a_b}};
  Append(rigid_groups_.Path(h.b, h.a), &steps);
  return steps;
}

}  // namespace isthmus::match_graph
