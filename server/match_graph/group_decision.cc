#include "server/match_graph/group_decision.h"

#include <algorithm>
#include <cmath>
#include <iterator>

namespace isthmus::match_graph {
namespace {

// The log odds that two group hypotheses on one frame are not both wrong in the same way.
double AgainstBothWrong(const GroupHypothesis& p, const GroupHypothesis& q, bool same_ground,
                        const GroupOptions& options) {
  if (same_ground) return std::max(p.log_odds, q.log_odds);
  return p.log_odds + q.log_odds - std::log(options.chance);
}

}  // namespace

GroupDecisionSearch::GroupDecisionSearch(const Evidence& evidence, const RigidGroups& rigid_groups,
                                         const GroupHypotheses& groups, const GroupOptions& options)
    : evidence_(evidence),
      rigid_groups_(rigid_groups),
      search_(groups),
      options_(options),
      least_two_(std::log(options.min_probability / (1 - options.min_probability)) +
                 std::log(options.chance)) {}

// Between all pairs of frames that anything is said of; those known before stay.
void GroupDecisionSearch::FindGroups() {
  std::map<FramePair, std::vector<const OpenPair*>> fresh;
  for (const OpenPair& pair : evidence_.pairs) {
    const FramePair frames =
        std::minmax(rigid_groups_.FrameOf(pair.a), rigid_groups_.FrameOf(pair.b));
    if (frames.first == frames.second || groups_.contains(frames)) continue;
    fresh[frames].push_back(&pair);
  }
  for (const auto& [frames, pairs] : fresh) groups_[frames] = search_.Between(frames.first, pairs);
}

GroupDecision GroupDecisionSearch::FindPair() const {
  GroupDecision best;
  for (const auto& [pair, groups] : groups_) {
    for (const GroupHypothesis& group : groups) {
      if (group.grounds < 2 || group.probability < options_.min_probability) continue;
      if (group.probability > best.probability) best = {group.probability, {&group}};
    }
  }
  return best;
}

GroupDecision GroupDecisionSearch::FindTriple() {
  GroupDecision best;
  for (auto xy = groups_.begin(); xy != groups_.end(); ++xy) {
    const auto [x, y] = xy->first;
    for (auto xz = std::next(xy); xz != groups_.end() && xz->first.first == x; ++xz) {
      const auto yz = groups_.find({y, xz->first.second});
      if (yz == groups_.end()) continue;
      const GroupDecision found = SettleThree(xy->second, yz->second, xz->second);
      if (found.probability > best.probability) best = found;
    }
  }
  return best.probability >= options_.min_probability ? best : GroupDecision();
}

// The best way round three frames, beside all others that close.
GroupDecision GroupDecisionSearch::SettleThree(const std::vector<GroupHypothesis>& xy,
                                               const std::vector<GroupHypothesis>& yz,
                                               const std::vector<GroupHypothesis>& xz) {
  GroupDecision best;
  double best_odds = 0, sum = 0;
  for (const GroupHypothesis& p : xy) {
    for (const GroupHypothesis& q : yz) {
      for (const GroupHypothesis& r : xz) {
        const std::optional<double> wrong = OddsOfWrong(p, q, r);
        if (!wrong) continue;
        const double odds = std::exp(p.log_odds + q.log_odds + r.log_odds);
        sum += odds;
        if (odds <= best_odds) continue;
        best_odds = odds;
        best = {1 / (1 + *wrong), {&p, &q, &r}};
      }
    }
  }
  if (best_odds > 0) best.probability *= best_odds / sum;
  return best;
}

// The odds that any of the three is wrong, against all being right; nothing if that is not worth a
// look or they do not close.
std::optional<double> GroupDecisionSearch::OddsOfWrong(const GroupHypothesis& xy,
                                                       const GroupHypothesis& yz,
                                                       const GroupHypothesis& xz) {
  if (triples_ >= options_.max_triples) return std::nullopt;
  // The two least certain ones must not both be wrong, on whatever ground.
  const double least_two =
      xy.log_odds + yz.log_odds + xz.log_odds - std::max({xy.log_odds, yz.log_odds, xz.log_odds});
  if (least_two < least_two_) return std::nullopt;
  const auto wrong = [&](bool same_x, bool same_y, bool same_z) {
    return std::exp(-AgainstBothWrong(xy, xz, same_x, options_)) +
           std::exp(-AgainstBothWrong(xy, yz, same_y, options_)) +
           std::exp(-AgainstBothWrong(yz, xz, same_z, options_)) +
           options_.chance * std::exp(-xy.log_odds - yz.log_odds - xz.log_odds);
  };
  if (wrong(false, false, false) > 1 / options_.min_probability - 1) return std::nullopt;
  ++triples_;
  if (!search_.MayClose(xy.constraint, yz.constraint, xz.constraint)) return std::nullopt;
  const std::vector<Step> round = search_.StepsRound(xy.constraint, yz.constraint, xz.constraint);
  if (!GoRound(round, options_.cycles).Agrees()) return std::nullopt;
  return wrong(AreSameGround(xy.ground, xz.ground, options_.cycles),
               AreSameGround(xy.far_ground, yz.ground, options_.cycles),
               AreSameGround(yz.far_ground, xz.far_ground, options_.cycles));
}

GroupDecision GroupDecisionSearch::Find() {
  FindGroups();
  const GroupDecision pair = FindPair();
  return pair.groups.empty() ? FindTriple() : pair;
}

void GroupDecisionSearch::Forget(const std::set<uint32_t>& frames) {
  std::erase_if(groups_, [&](const auto& entry) {
    return frames.contains(entry.first.first) || frames.contains(entry.first.second);
  });
}

}  // namespace isthmus::match_graph
