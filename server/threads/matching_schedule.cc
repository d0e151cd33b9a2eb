#include "server/threads/matching_schedule.h"

#include <algorithm>
#include <iterator>
#include <set>
#include <variant>

#include "server/jobs/limits.h"
#include "server/matching/index/limits.h"
#include "server/threads/anchor_index.h"
#include "server/threads/next_partners.h"

namespace isthmus::server {
namespace {

// The value that a map holds for a key; a default one if it holds none.
template <typename Map>
typename Map::mapped_type ValueOr(const Map& map, const typename Map::key_type& key) {
  const auto it = map.find(key);
  return it == map.end() ? typename Map::mapped_type{} : it->second;
}

// Number of placed submaps that were not searched for loops yet.
uint64_t CountForLoops(const MapView& view, const MatchingLedger& ledger) {
  uint64_t count = 0;
  for (const Placement& placement : view.revision->placements) {
    const uint32_t next = ValueOr(ledger.looped, placement.session);
    for (auto pose = placement.submaps.rbegin(); pose != placement.submaps.rend(); ++pose) {
      if (pose->index < next) break;
      ++count;
    }
  }
  return count;
}

// A session that is to be compared with all others: it is new, or has grown by a good part.
std::optional<SessionId> NextToIndex(const MapView& view, const MatchingLedger& ledger) {
  for (const auto& [id, session] : view.sessions) {
    if (!IsMatchable(session)) continue;
    const uint32_t before = ValueOr(ledger.indexed, id), now = session.next_index();
    const bool has_grown = before == 0 ? now >= kMinIndexedSubmaps
                                       : now >= kIndexedGrowth * static_cast<double>(before);
    if (has_grown || (IsFinished(session) && now > before)) return id;
  }
  return std::nullopt;
}

// The number of new submaps that the pair has since it was tried, and one for each map that its
// loops have moved; 0 where it is not worth a try.
uint32_t FreshSubmaps(const MapView& view, const MatchingLedger& ledger, const SessionView& a,
                      const SessionView& b, const Attempt& tried, const ScheduleOptions& options) {
  const uint32_t fresh_a = a.next_index() - std::min(a.next_index(), tried.next_a);
  const uint32_t fresh_b = b.next_index() - std::min(b.next_index(), tried.next_b);
  const uint32_t moved = (tried.shape_a != ValueOr(ledger.shapes, a.record.id) ? 1 : 0) +
                         (tried.shape_b != ValueOr(ledger.shapes, b.record.id) ? 1 : 0);
  const uint32_t fresh = fresh_a + fresh_b + moved;
  if (tried.next_a + tried.next_b == 0 || (IsFinished(a) && IsFinished(b))) return fresh;
  if (view.sessions.size() > kMaxPreparedMaps) {
    const bool grown_a = fresh_a > 0 && fresh_a >= kSeldomGrowth * tried.next_a;
    const bool grown_b = fresh_b > 0 && fresh_b >= kSeldomGrowth * tried.next_b;
    if (!grown_a && !grown_b) return 0;
  }
  const auto least = static_cast<uint32_t>(std::max(options.rematch_submaps, 1));
  return moved > 0 || fresh >= least ? fresh : 0;
}

// The pair with the most new evidence, if partners are selected of those tried before, and how many
// have some.
struct Freshest {
  std::optional<SessionPair> pair;
  uint64_t waiting = 0;
};
Freshest FreshestPair(const MapView& view, const MatchingLedger& ledger, bool selects_partners,
                      const ScheduleOptions& options) {
  const AnchorIndex anchors(view);
  Freshest freshest;
  uint32_t most = 0;
  const auto consider = [&](const SessionView& a, const SessionView& b, const Attempt& tried) {
    const SessionPair pair(a.record.id, b.record.id);
    if (ledger.posted.contains(MatchKey{pair})) return;
    uint32_t fresh = FreshSubmaps(view, ledger, a, b, tried, options);
    if (fresh == 0 && tried.anchors != anchors.Version(pair)) fresh = 1;
    freshest.waiting += fresh > 0 ? 1 : 0;
    if (fresh <= most) return;
    most = fresh;
    freshest.pair = pair;
  };
  if (selects_partners) {
    // Among thousands of sessions a few pairs were tried; the same order as below.
    for (const auto& [pair, tried] : ledger.attempts) {
      const SessionView *a = view.Find(pair.first), *b = view.Find(pair.second);
      if (a != nullptr && b != nullptr && IsMatchable(*a) && IsMatchable(*b)) {
        consider(*a, *b, tried);
      }
    }
    return freshest;
  }
  for (auto a = view.sessions.begin(); a != view.sessions.end(); ++a) {
    if (!IsMatchable(a.value())) continue;
    for (auto b = std::next(a); b != view.sessions.end(); ++b) {
      if (!IsMatchable(b.value())) continue;
      consider(a.value(), b.value(), ValueOr(ledger.attempts, SessionPair(a.key(), b.key())));
    }
  }
  return freshest;
}

// The version of no shape.
constexpr uint32_t kOutdated = ~uint32_t{0};  // Format.

// The next index that a session had when a match of it was computed, which says only of how many
// submaps: those retired since do not make it worth another try.
uint32_t TriedUpTo(const SessionView& entry, uint32_t submaps, int64_t computed_ns) {
  // Before its last submaps may be before its last word, too.
  if (IsFinished(entry) && computed_ns < entry.record.finished_ns) return submaps;
  const auto now = static_cast<uint32_t>(entry.submaps.size());
  return entry.next_index() - (now > submaps ? now - submaps : 0);
}

// True if loops have come that the match may not know of.
bool HasNewerLoops(const MapView& view, const SessionId& session, int64_t computed_ns) {
  return std::any_of(view.loops.begin(), view.loops.end(), [&](const auto& entry) {
    const LoopClosure& loop = entry.second;
    return loop.session == session && !loop.rejected && loop.computed_ns > computed_ns;
  });
}

bool MustCountRevisits(const MapView& view, const MatchingLedger& ledger) {
  return view.IsPlaced() && view.revision->revision != ledger.counted_revision;
}

}  // namespace

NextJob ChooseNext(const MapView& view, const MatchingLedger& ledger,
                   const ScheduleOptions& options) {
  NextJob next;
  if (options.find_loops) next.waiting_submaps = CountForLoops(view, ledger);
  if (const auto submap = NextForLoops(view, ledger, options)) {
    next.key = LoopKey{*submap};
    return next;
  }
  if (!ledger.outdated_shapes.empty()) {
    next.key = ShapeKey{*ledger.outdated_shapes.begin()};
    return next;
  }
  const bool has_room = ledger.posted.size() < kMaxPostedJobs;
  const bool selects_partners = SelectsPartners(view);
  std::optional<SessionPair> pair;
  if (selects_partners) {
    if (const auto session = NextToIndex(view, ledger); session && has_room) {
      next.key = IndexKey{*session};
      return next;
    }
    // Likely partners come before pairs that were tried before.
    pair = NextPartners(view, ledger);
  }
  const Freshest freshest = FreshestPair(view, ledger, selects_partners, options);
  next.waiting_pairs = freshest.waiting + (pair ? 1 : 0);
  if (!pair) pair = freshest.pair;
  if (pair && has_room) {
    next.key = MatchKey{*pair};
  } else if (options.count_revisits && MustCountRevisits(view, ledger)) {
    next.key = RevisitsKey();
  }
  return next;
}

std::optional<SubmapId> NextForLoops(const MapView& view, const MatchingLedger& ledger,
                                     const ScheduleOptions& options) {
  if (!options.find_loops) return std::nullopt;
  std::set<SessionId> posted;
  for (const auto& [key, since] : ledger.posted) {
    if (const auto* loops = std::get_if<LoopKey>(&key)) posted.insert(loops->submap.session);
  }
  for (const Placement& placement : view.revision->placements) {
    const SessionId& session = placement.session;
    if (view.Find(session) == nullptr || posted.contains(session)) continue;
    const auto first = std::lower_bound(
        placement.submaps.begin(), placement.submaps.end(), ValueOr(ledger.looped, session),
        [](const SubmapPose& pose, uint32_t next) { return pose.index < next; });
    if (first != placement.submaps.end()) return SubmapId{session, first->index};
  }
  return std::nullopt;
}

MatchTrigger TriggerOf(const MapView& view, const MatchingLedger& ledger, const SessionPair& pair,
                       const ScheduleOptions& options) {
  const SessionView &a = *view.Find(pair.first), &b = *view.Find(pair.second);
  const bool is_last =
      IsFinished(a) && IsFinished(b) &&
      FreshSubmaps(view, ledger, a, b, ValueOr(ledger.attempts, pair), options) > 0;
  return {.last_submaps = is_last, .first_look = SelectsPartners(view) && !AreSegments(a, b)};
}

Attempt AttemptNow(const MapView& view, const MatchingLedger& ledger, const SessionPair& pair) {
  return {view.Find(pair.first)->next_index(), view.Find(pair.second)->next_index(),
          ValueOr(ledger.shapes, pair.first), ValueOr(ledger.shapes, pair.second),
          AnchorIndex(view).Version(pair)};
}

Attempt AttemptOf(const MapView& view, const SessionPair& pair, uint32_t submaps_a,
                  uint32_t submaps_b, int64_t computed_ns) {
  const auto shape = [&](const SessionId& session) {
    return HasNewerLoops(view, session, computed_ns) ? kOutdated : 0;
  };
  return {TriedUpTo(*view.Find(pair.first), submaps_a, computed_ns),
          TriedUpTo(*view.Find(pair.second), submaps_b, computed_ns), shape(pair.first),
          shape(pair.second)};
}

bool SelectsPartners(const MapView& view) {
  const auto count = std::count_if(view.sessions.begin(), view.sessions.end(),
                                   [](const auto& s) { return IsMatchable(s.second); });
  return static_cast<size_t>(count) > matching::kSearchAllSessions;
}

std::map<SessionId, PairCounts> CountTried(const MapView& view, const SessionProximity& proximity,
                                           const MatchingLedger& ledger) {
  std::map<SessionId, PairCounts> count;
  for (const auto& [pair, attempt] : ledger.attempts) {
    const std::shared_ptr<const Match> match = view.matches.Get(pair);
    const bool looked = match != nullptr && match->reason == MatchReason::kNoCandidate;
    const bool joined = proximity.AreJoined(pair);
    for (const SessionId& id : {pair.first, pair.second}) {
      ++count[id].pairs;
      if (!looked) ++count[id].searched;
      if (joined) ++count[id].joined;
    }
  }
  return count;
}

}  // namespace isthmus::server
