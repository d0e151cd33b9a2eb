#include "server/match_graph/claims.h"

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

bool OfOnePair(const Link& p, const Link& q) { return p.from == q.from && p.to == q.to; }

// Ties are left to which came first.
bool IsBetter(const Link& p, const Link& q) {
  return p.hypothesis->log_odds > q.hypothesis->log_odds;
}

// Fills the probabilities: one of the claims is right, or none of them. Claims whose middle
// belongs to a better one are that one over again.
void Weigh(std::vector<Claim>* claims) {
  std::set<const Hypothesis*> taken;
  std::vector<Claim> kept;
  double sum = 1;
  for (Claim& claim : *claims) {
    if (taken.contains(claim.link.hypothesis)) continue;
    taken.insert(claim.members.begin(), claim.members.end());
    sum += std::exp(claim.log_odds);
    kept.push_back(std::move(claim));
  }
  for (Claim& claim : kept) claim.probability = std::exp(claim.log_odds) / sum;
  *claims = std::move(kept);
}

}  // namespace

Link Claims::MakeLink(const Hypothesis& h, uint32_t first) const {
  Link link{&h, h.a, h.b, h.T_a_b, {}, h.ground_a, h.ground_b};
  if (frames_.FrameOf(h.a) != first) {
    std::swap(link.from, link.to);
    std::swap(link.ground, link.far_ground);
    link.T_from_to = h.T_a_b.Inverse();
  }
  const Pose &T_first = frames_.T_frame_odom(link.from), &T_second = frames_.T_frame_odom(link.to);
  link.T_first_second = T_first * link.T_from_to * T_second.Inverse();
  for (Eigen::Vector3d& p : link.ground) p = T_first * p;
  for (Eigen::Vector3d& p : link.far_ground) p = T_second * p;
  return link;
}

// There by one, back by the other.
std::vector<Step> Claims::StepsBetween(const Link& p, const Link& q) const {
  std::vector<Step> steps = {{&evidence_.nodes[p.from], p.T_from_to}};
  Append(frames_.Way(p.to, q.to), &steps);
  steps.push_back({&evidence_.nodes[q.to], q.T_from_to.Inverse()});
  Append(frames_.Way(q.from, p.from), &steps);
  return steps;
}

double Claims::MostDegrees() const {
  const auto most = static_cast<double>(evidence_.nodes.size());
  return options_.cycles.max_deg * std::sqrt(std::max(1.0, most / 3));
}

bool Claims::MayClose(const Link& xy, const Link& yz, const Link& xz) const {
  // Frames are named by their first node, so that the second one of xy is the first of yz.
  const Pose left = xy.T_first_second * yz.T_first_second * xz.T_first_second.Inverse();
  return RotationAngle(left) * 180 / std::numbers::pi <= MostDegrees();
}

bool Claims::Agree(const Link& p, const Link& q) const {
  // Most do not, by far.
  const double rad = RotationAngle(p.T_first_second.Inverse() * q.T_first_second);
  return rad * 180 / std::numbers::pi <= MostDegrees() &&
         GoRound(StepsBetween(p, q), options_.cycles).Agrees();
}

bool Claims::IsContradicted(const Link& link, const std::vector<const OpenPair*>& pairs) const {
  for (const OpenPair* pair : pairs) {
    for (const Hypothesis& h : pair->contradicted) {
      if (Agree(link, MakeLink(h, frames_.FrameOf(link.from)))) return true;
    }
  }
  return false;
}

Claim Claims::MakeClaim(const std::vector<Link>& links, size_t center) const {
  std::vector<const Link*> members = {&links[center]};
  for (const Link& link : links) {
    if (OfOnePair(link, links[center]) || !Agree(links[center], link)) continue;
    const auto known = std::find_if(members.begin(), members.end(),
                                    [&](const Link* other) { return OfOnePair(link, *other); });
    if (known == members.end()) {
      members.push_back(&link);
    } else if (IsBetter(link, **known)) {
      *known = &link;
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
  Claim claim;
  claim.link = links[center];
  std::map<size_t, double> best;  // Log odds by place: what rests on one is wrong together.
  for (size_t i = 0; i < members.size(); ++i) {
    const Hypothesis& h = *members[i]->hypothesis;
    claim.members.push_back(&h);
    AppendPoints(members[i]->ground, &claim.ground);
    AppendPoints(members[i]->far_ground, &claim.far_ground);
    const auto [known, is_new] = best.emplace(places.Find(i), h.log_odds);
    known->second = std::max(known->second, h.log_odds);
  }
  std::vector<double> odds;
  for (const auto& [place, log_odds] : best) odds.push_back(log_odds);
  std::sort(odds.rbegin(), odds.rend());
  claim.log_odds = odds.front();
  claim.grounds = 1;
  for (size_t i = 1; i < odds.size(); ++i) {
    // Wrong by itself as a rule, but wrong in just this way it would be by chance.
    const double more = odds[i] - std::log(options_.chance);
    if (more <= 0) continue;
    claim.log_odds += more;
    ++claim.grounds;
  }
  return claim;
}

std::vector<Claim> Claims::Between(uint32_t x, const std::vector<const OpenPair*>& pairs) const {
  std::vector<Link> links;
  for (const OpenPair* pair : pairs) {
    for (const Hypothesis& h : pair->hypotheses) links.push_back(MakeLink(h, x));
  }
  std::stable_sort(links.begin(), links.end(), IsBetter);
  if (links.size() > options_.max_between) links.resize(options_.max_between);
  std::erase_if(links, [&](const Link& link) { return IsContradicted(link, pairs); });
  std::vector<Claim> claims;
  for (size_t i = 0; i < links.size(); ++i) claims.push_back(MakeClaim(links, i));
  std::stable_sort(claims.begin(), claims.end(), [](const Claim& l, const Claim& r) {
    return std::make_tuple(l.log_odds, l.link.hypothesis->log_odds) >
           std::make_tuple(r.log_odds, r.link.hypothesis->log_odds);
  });
  Weigh(&claims);
  return claims;
}

std::vector<Step> Claims::StepsBack(const Link& link, const Hypothesis& by) const {
  return StepsBetween(link, MakeLink(by, frames_.FrameOf(link.from)));
}

std::vector<Step> Claims::StepsRound(const Link& xy, const Link& yz, const Link& xz) const {
  std::vector<Step> steps = {{&evidence_.nodes[xy.from], xy.T_from_to}};
  Append(frames_.Way(xy.to, yz.from), &steps);
  steps.push_back({&evidence_.nodes[yz.from], yz.T_from_to});
  Append(frames_.Way(yz.to, xz.to), &steps);
  steps.push_back({&evidence_.nodes[xz.to], xz.T_from_to.Inverse()});
  Append(frames_.Way(xz.from, xy.from), &steps);
  return steps;
}

std::vector<Step> Claims::StepsBack(const Hypothesis& h) const {
  std::vector<Step> steps = {{&evidence_.nodes[h.a], h.T_a_b}};
  Append(frames_.Way(h.b, h.a), &steps);
  return steps;
}

}  // namespace isthmus::match_graph
