#include "server/threads/next_partners.h"

#include <algorithm>
#include <functional>
#include <iterator>
#include <map>
#include <vector>

#include "server/threads/matching_schedule.h"
#include "server/threads/session_proximity.h"

namespace isthmus::server {
namespace {

using IsNew = std::function<bool(const SessionPair&)>;

// Segments of one session, and neighbours by anchors.
std::optional<SessionPair> NextKnownPartners(const MapView& view, const SessionProximity& proximity,
                                             const IsNew& is_new) {
  // Few of thousands of sessions have segments or anchors.
  std::vector<const SessionView*> related;
  for (const auto& [id, session] : view.sessions) {
    if (!IsMatchable(session)) continue;
    if (session.record.segment > 1 || proximity.IsAnchored(id) ||
        view.Find(SegmentId(id, 2)) != nullptr) {
      related.push_back(&session);
    }
  }
  for (auto a = related.begin(); a != related.end(); ++a) {
    for (auto b = std::next(a); b != related.end(); ++b) {
      const SessionPair pair((*a)->record.id, (*b)->record.id);
      const bool are_near = proximity.IsAnchored(pair.first) && proximity.IsAnchored(pair.second) &&
                            proximity.Nearness(pair) > 0;
      if ((AreSegments(**a, **b) || are_near) && is_new(pair)) return pair;
    }
  }
  return std::nullopt;
}

// The first of the ranked pairs in each of its kinds.
struct Promising {
  std::optional<SessionPair> at_hand, apart, joined;
};
Promising MostPromising(const MatchingLedger& ledger, const SessionProximity& proximity,
                        std::map<SessionId, PairCounts>& tried, const IsNew& is_new) {
  const auto has_room = [&](const SessionId& id) {
    const auto allowed = ledger.allowed.find(id);
    return allowed != ledger.allowed.end() && allowed->second.HasRoom(tried[id]);
  };
  const auto is_at_hand = [&](const SessionId& id) {
    return ledger.last_pair && (ledger.last_pair->first == id || ledger.last_pair->second == id);
  };
  Promising promising;
  for (const matching::RankedPair& pair : ledger.ranked) {
    const auto& [a, b] = pair.sessions;
    if (!is_new(pair.sessions) || !(has_room(a) || has_room(b))) continue;
    const bool is_joined = proximity.AreJoined(pair.sessions);
    if (!is_joined && (is_at_hand(a) || is_at_hand(b))) {
      promising.at_hand = pair.sessions;
      return promising;
    }
    std::optional<SessionPair>& first = is_joined ? promising.joined : promising.apart;
    if (!first) first = pair.sessions;
  }
  return promising;
}

}  // namespace

bool AreSegments(const SessionView& a, const SessionView& b) {
  return a.record.opened() == b.record.opened();
}

std::optional<SessionPair> NextPartners(const MapView& view, const MatchingLedger& ledger) {
  const SessionProximity proximity(view);
  const auto is_new = [&](const SessionPair& pair) {
    const SessionView *a = view.Find(pair.first), *b = view.Find(pair.second);
    return a != nullptr && b != nullptr && IsMatchable(*a) && IsMatchable(*b) &&
           !ledger.attempts.contains(pair);
  };
  const auto unfinished = std::find_if(ledger.unfinished.begin(), ledger.unfinished.end(), is_new);
  if (unfinished != ledger.unfinished.end()) return *unfinished;
  if (const auto known = NextKnownPartners(view, proximity, is_new)) return known;
  std::map<SessionId, PairCounts> tried = CountTried(view, proximity, ledger);
  const Promising promising = MostPromising(ledger, proximity, tried, is_new);
  if (promising.at_hand) return promising.at_hand;
  if (promising.apart) return promising.apart;
  for (const auto& [id, allowed] : ledger.allowed) {
    if (!allowed.HasRoomNear(tried[id])) continue;
    const auto nearest = proximity.NearestJoined(
        id, [&, &id = id](const SessionId& other) { return is_new(std::minmax(id, other)); });
    if (nearest) return std::minmax(id, *nearest);
  }
  return promising.joined;
}

}  // namespace isthmus::server
