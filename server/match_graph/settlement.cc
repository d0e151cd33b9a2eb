#include "server/match_graph/settlement.h"

#include <algorithm>
#include <cmath>
#include <iterator>

namespace isthmus::match_graph {
namespace {

// The log odds that two claims on one frame are not both wrong in the same way.
double AgainstBothWrong(const Claim& p, const Claim& q, bool same_ground,
                        const GroupOptions& options) {
  if (same_ground) return std::max(p.log_odds, q.log_odds);
  return p.log_odds + q.log_odds - std::log(options.chance);
}

}  // namespace

SettlementSearch::SettlementSearch(const Evidence& evidence, const Frames& frames,
                                   const Claims& claims, const GroupOptions& options)
    : evidence_(evidence),
      frames_(frames),
      search_(claims),
      options_(options),
      least_two_(std::log(options.min_probability / (1 - options.min_probability)) +
                 std::log(options.chance)) {}

// Between all pairs of frames that anything is said of; those known before stay.
void SettlementSearch::FindClaims() {
  std::map<FramePair, std::vector<const OpenPair*>> fresh;
  for (const OpenPair& pair : evidence_.pairs) {
    const FramePair frames = std::minmax(frames_.FrameOf(pair.a), frames_.FrameOf(pair.b));
    if (frames.first == frames.second || claims_.contains(frames)) continue;
    fresh[frames].push_back(&pair);
  }
  for (const auto& [frames, pairs] : fresh) claims_[frames] = search_.Between(frames.first, pairs);
}

Settlement SettlementSearch::FindPair() const {
  Settlement best;
  for (const auto& [pair, claims] : claims_) {
    for (const Claim& claim : claims) {
      if (claim.grounds < 2 || claim.probability < options_.min_probability) continue;
      if (claim.probability > best.probability) best = {claim.probability, {&claim}};
    }
  }
  return best;
}

Settlement SettlementSearch::FindTriple() {
  Settlement best;
  for (auto xy = claims_.begin(); xy != claims_.end(); ++xy) {
    const auto [x, y] = xy->first;
    for (auto xz = std::next(xy); xz != claims_.end() && xz->first.first == x; ++xz) {
      const auto yz = claims_.find({y, xz->first.second});
      if (yz == claims_.end()) continue;
      const Settlement found = SettleThree(xy->second, yz->second, xz->second);
      if (found.probability > best.probability) best = found;
    }
  }
  return best.probability >= options_.min_probability ? best : Settlement();
}

// The best way round three frames, beside all others that close.
Settlement SettlementSearch::SettleThree(const std::vector<Claim>& xy, const std::vector<Claim>& yz,
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

// The odds that any of the three is wrong, against all being right; nothing if that is not worth a
// look or they do not close.
std::optional<double> SettlementSearch::OddsOfWrong(const Claim& xy, const Claim& yz,
                                                    const Claim& xz) {
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
  if (!search_.MayClose(xy.link, yz.link, xz.link)) return std::nullopt;
  const std::vector<Step> round = search_.StepsRound(xy.link, yz.link, xz.link);
  if (!GoRound(round, options_.cycles).Agrees()) return std::nullopt;
  return wrong(AreSameGround(xy.ground, xz.ground, options_.cycles),
               AreSameGround(xy.far_ground, yz.ground, options_.cycles),
               AreSameGround(yz.far_ground, xz.far_ground, options_.cycles));
}

Settlement SettlementSearch::Find() {
  FindClaims();
  const Settlement pair = FindPair();
  return pair.claims.empty() ? FindTriple() : pair;
}

void SettlementSearch::Forget(const std::set<uint32_t>& frames) {
  std::erase_if(claims_, [&](const auto& entry) {
    return frames.contains(entry.first.first) || frames.contains(entry.first.second);
  });
}

}  // namespace isthmus::match_graph
