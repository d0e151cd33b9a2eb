#include "server/matching/index/place_index.h"

#include <algorithm>
#include <set>

#include "server/matching/index/limits.h"

namespace isthmus::matching {
namespace {

// The middle and the spread of a session's scores.
struct Usual {
  double middle = 0, spread = 0;
};

Usual UsualOf(const std::map<SessionId, double>& of_session) {
  std::vector<double> scores;
  for (const auto& [partner, score] : of_session) scores.push_back(score);
  std::sort(scores.begin(), scores.end());
  const auto at = [&](double share) {
    return scores[static_cast<size_t>(share * static_cast<double>(scores.size() - 1))];
  };
  return {at(0.5), at(kHighShare) - at(kLowShare)};
}

bool IsLikelier(const RankedPair& a, const RankedPair& b) {
  return a.promise > b.promise || (a.promise == b.promise && a.sessions < b.sessions);
}

}  // namespace

std::vector<RankedPair> TakePartners(const std::vector<RankedPair>& ranked, size_t partners) {
  std::map<SessionId, size_t> count;
  std::vector<RankedPair> taken;
  for (const RankedPair& pair : ranked) {
    size_t &a = count[pair.sessions.first], &b = count[pair.sessions.second];
    if (a >= partners && b >= partners) continue;
    ++a;
    ++b;
    taken.push_back(pair);
  }
  return taken;
}

void PlaceIndex::Put(const SessionId& a, const SessionId& b, double score) {
  if (a == b) return;
  scores_[a][b] = score;
  scores_[b][a] = score;
}

bool PlaceIndex::Has(const SessionId& a, const SessionId& b) const {
  const auto it = scores_.find(a);
  return it != scores_.end() && it->second.contains(b);
}

void PlaceIndex::Forget(const SessionId& session) {
  scores_.erase(session);
  for (auto& [other, of_other] : scores_) of_other.erase(session);
  std::erase_if(scores_, [](const auto& item) { return item.second.empty(); });
}

void PlaceIndex::ForgetIf(const std::function<bool(const SessionId&)>& goes) {
  std::vector<SessionId> gone;
  for (const auto& [session, of_session] : scores_) {
    if (goes(session)) gone.push_back(session);
  }
  for (const SessionId& session : gone) Forget(session);
}

std::vector<RankedPair> PlaceIndex::Rank(size_t partners) const {
  std::map<SessionId, Usual> usual;
  std::vector<double> spreads;
  for (const auto& [session, of_session] : scores_) {
    spreads.push_back(usual.emplace(session, UsualOf(of_session)).first->second.spread);
  }
  if (spreads.empty()) return {};
  const auto middle = spreads.begin() + static_cast<std::ptrdiff_t>(spreads.size() / 2);
  std::nth_element(spreads.begin(), middle, spreads.end());
  // Added to each, so that a session whose scores are all alike does not come first everywhere.
  const double common = std::max(*middle, 1e-9);
  const auto standing = [&](const SessionId& session, double score) {
    const Usual& of = usual.at(session);
    return (score - of.middle) / (of.spread + common);
  };
  std::set<std::pair<SessionId, SessionId>> taken;
  std::vector<RankedPair> ranked;
  for (const auto& [session, of_session] : scores_) {
    std::vector<RankedPair> own;
    for (const auto& [partner, score] : of_session) {
      const double a = standing(session, score), b = standing(partner, score);
      own.push_back({std::minmax(session, partner), std::min(a, b) + kSumShare * (a + b)});
    }
    const size_t count = std::min(partners, own.size());
    std::partial_sort(own.begin(), own.begin() + static_cast<std::ptrdiff_t>(count), own.end(),
                      IsLikelier);
    own.resize(count);
    for (RankedPair& pair : own) {
      if (taken.insert(pair.sessions).second) ranked.push_back(std::move(pair));
    }
  }
  std::sort(ranked.begin(), ranked.end(), IsLikelier);
  return ranked;
}

}  // namespace isthmus::matching
