#include "server/match_graph/groups.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>
#include <absl/strings/str_join.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>

#include "server/match_graph/claims.h"
#include "server/match_graph/evidence.h"
#include "server/match_graph/frames.h"
#include "server/match_graph/limits.h"

namespace isthmus::match_graph {
namespace {

using FramePair = std::pair<uint32_t, uint32_t>;

// Claims that are accepted together: one, or three that close.
struct Settlement {
  double probability = 0;
  std::vector<const Claim*> claims;
};

// Why a match is accepted.
struct Why {
  double probability = 0;
  std::vector<Step> round;  // A way round on which it lies.
};

// The log odds that two claims on one frame are not both wrong in the same way.
double AgainstBothWrong(const Claim& p, const Claim& q, bool same_ground,
                        const GroupOptions& options) {
  if (same_ground) return std::max(p.log_odds, q.log_odds);
  return p.log_odds + q.log_odds - std::log(options.chance);
}

class Settling {
 public:
  Settling(const std::vector<Node>& nodes, const GroupOptions& options,
           std::vector<Match>* matches)
      : options_(options),
        evidence_(CollectEvidence(nodes, options, matches)),
        frames_(evidence_.nodes),
        search_(evidence_, frames_, options_) {}

  void Run() {
    for (const Hypothesis& joint : evidence_.joints) frames_.Join(joint.a, joint.b, joint.T_a_b);
    for (;;) {
      FindClaims();
      Settlement best = BestPair();
      if (best.claims.empty()) best = BestTriple();
      if (best.claims.empty()) break;
      JoinBy(best);
    }
    for (const OpenPair& pair : evidence_.pairs) {
      if (frames_.Together(pair.a, pair.b)) SettleWithin(pair);
    }
  }

 private:
  // By the most probable hypothesis that agrees with the frame.
  void SettleWithin(const OpenPair& pair) {
    for (const Hypothesis& h : pair.hypotheses) {
      // Those that frames were joined by lead nowhere but back along themselves.
      const auto known = why_.find(&h);
      const Why why = known != why_.end()
                          ? known->second
                          : Why{options_.min_probability, search_.StepsBack(h)};
      if (GoRound(why.round, options_.cycles).Agrees()) return Accept(h, why);
    }
  }

  // Between all pairs of frames that anything is said of; those known before stay.
  void FindClaims() {
    std::map<FramePair, std::vector<const OpenPair*>> fresh;
    for (const OpenPair& pair : evidence_.pairs) {
      const FramePair frames = std::minmax(frames_.FrameOf(pair.a), frames_.FrameOf(pair.b));
      if (frames.first == frames.second || claims_.contains(frames)) continue;
      fresh[frames].push_back(&pair);
    }
    for (const auto& [frames, pairs] : fresh) {
      claims_[frames] = search_.Between(frames.first, pairs);
    }
  }

  Settlement BestPair() const {
    Settlement best;
    for (const auto& [pair, claims] : claims_) {
      for (const Claim& claim : claims) {
        if (claim.grounds < 2 || claim.probability < options_.min_probability) continue;
        if (claim.probability > best.probability) best = {claim.probability, {&claim}};
      }
    }
    return best;
  }

  const std::vector<Claim>& ClaimsOf(uint32_t x, uint32_t y) const {
    static const std::vector<Claim>& kNone = *new std::vector<Claim>();
    const auto known = claims_.find({x, y});
    return known == claims_.end() ? kNone : known->second;
  }

  Settlement BestTriple() {
    Settlement best;
    for (auto xy = claims_.begin(); xy != claims_.end(); ++xy) {
      const auto [x, y] = xy->first;
      for (auto xz = std::next(xy); xz != claims_.end() && xz->first.first == x; ++xz) {
        const std::vector<Claim>& yz = ClaimsOf(y, xz->first.second);
        if (yz.empty()) continue;
        const Settlement found = SettleThree(xy->second, yz, xz->second);
        if (found.probability > best.probability) best = found;
      }
    }
    return best.probability >= options_.min_probability ? best : Settlement();
  }

  // The best way round three frames, beside all others that close.
  Settlement SettleThree(const std::vector<Claim>& xy, const std::vector<Claim>& yz,
                         const std::vector<Claim>& xz) {
    Settlement best;
    double best_odds = 0, sum = 0;
    for (const Claim& p : xy) {
      for (const Claim& q : yz) {
        for (const Claim& r : xz) {
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

  // How much more probable it is that any of the three is wrong than that all are right; nothing
  // where that is not worth a look or they do not close.
  std::optional<double> OddsOfWrong(const Claim& xy, const Claim& yz, const Claim& xz) {
    const auto wrong = [&](bool same_x, bool same_y, bool same_z) {
      return std::exp(-AgainstBothWrong(xy, xz, same_x, options_)) +
             std::exp(-AgainstBothWrong(xy, yz, same_y, options_)) +
             std::exp(-AgainstBothWrong(yz, xz, same_z, options_)) +
             options_.chance * std::exp(-xy.log_odds - yz.log_odds - xz.log_odds);
    };
    if (wrong(false, false, false) > 1 / options_.min_probability - 1) return std::nullopt;
    if (++triples_ > options_.max_triples) return std::nullopt;
    const std::vector<Step> round = search_.StepsRound(xy.link, yz.link, xz.link);
    if (!GoRound(round, options_.cycles).Agrees()) return std::nullopt;
    return wrong(AreSameGround(xy.ground, xz.ground, options_.cycles),
                 AreSameGround(xy.far_ground, yz.ground, options_.cycles),
                 AreSameGround(yz.far_ground, xz.far_ground, options_.cycles));
  }

  void JoinBy(const Settlement& settlement) {
    std::set<uint32_t> changed;
    std::vector<Link> links;
    for (const Claim* claim : settlement.claims) {
      links.push_back(claim->link);
      changed.insert({frames_.FrameOf(claim->link.from), frames_.FrameOf(claim->link.to)});
    }
    const std::vector<Step> round =
        links.size() == 3 ? search_.StepsRound(links[0], links[1], links[2])
                          : search_.StepsBack(links[0], *settlement.claims[0]->members[1]);
    for (const Link& link : links) why_[link.hypothesis] = {settlement.probability, round};
    for (const Link& link : links) frames_.Join(link.from, link.to, link.T_from_to);
    for (const Claim* claim : settlement.claims) {
      for (const Hypothesis* member : claim->members) {
        why_.try_emplace(member, Why{settlement.probability, search_.StepsBack(*member)});
      }
    }
    std::erase_if(claims_, [&](const auto& entry) {
      return changed.contains(entry.first.first) || changed.contains(entry.first.second);
    });
  }

  // The sessions on the way that are not the hypothesis's.
  std::string NamesOfOthers(const Hypothesis& h, const std::vector<Step>& round) const {
    std::set<std::string> names;
    for (const Step& step : round) {
      const auto node = static_cast<size_t>(step.from - evidence_.nodes.data());
      if (node != h.a && node != h.b) names.insert(evidence_.sessions[node].value());
    }
    return absl::StrJoin(names, ", ");
  }

  void Accept(const Hypothesis& h, const Why& why) const {
    Match& match = *h.match;
    const std::string before = absl::StrCat(ToString(match.state), " ", ToString(match.reason),
                                            match.detail.empty() ? "" : ": ", match.detail);
    const Residual left = GoRound(why.round, options_.cycles);
    if (h.rival > 0) TakeRival(h.rival - 1, &match);
    match.state = MatchState::kAccepted;
    match.reason = MatchReason::kGroup;
    match.confidence = std::min(std::max(why.probability, match.confidence), kMaxConfidence);
    match.cycle_m = left.m;
    match.cycle_deg = left.deg;
    match.detail = absl::StrFormat(
        "Settled by way of %s: going round leaves %.2f m and %.1f deg where %.2f m and %.1f deg "
        "are allowed.%s By itself it was %s",
        NamesOfOthers(h, why.round), left.m, left.deg, left.max_m, left.max_deg,
        h.rival > 0 ? absl::StrFormat(" Taken is the alignment that was number %d for these two.",
                                      h.rival + 1)
                    : "",
        before);
  }

  // The match's own place among the rivals is the taken one's.
  static void TakeRival(size_t index, Match* match) {
    RivalMatch& rival = match->rivals[index];
    RivalMatch own{match->T_a_b,      match->state,         match->reason,
                   match->confidence, match->matcher,       match->overlap,
                   match->free_space, match->comparisons,   match->shared_area_m2,
                   std::move(match->edges)};
    match->T_a_b = rival.T_a_b;
    match->confidence = rival.confidence;
    match->matcher = rival.matcher;
    match->overlap = rival.overlap;
    match->runner_up = own.free_space;
    match->free_space = rival.free_space;
    match->comparisons = rival.comparisons;
    match->shared_area_m2 = rival.shared_area_m2;
    match->edges = std::move(rival.edges);
    // Of the other alignment.
    match->inliers = -1;
    match->inlier_ratio = match->residual_m = match->observability = match->odometry_residual = -1;
    rival = std::move(own);
  }

  const GroupOptions options_;
  const Evidence evidence_;
  Frames frames_;
  const Claims search_;
  std::map<FramePair, std::vector<Claim>> claims_;
  std::map<const Hypothesis*, Why> why_;  // Of what frames were joined by.
  size_t triples_ = 0;                    // Looked at so far.
};

}  // namespace

void SettleGroups(const std::vector<Node>& nodes, const GroupOptions& options,
                  std::vector<Match>* matches) {
  Settling(nodes, options, matches).Run();
}

}  // namespace isthmus::match_graph
