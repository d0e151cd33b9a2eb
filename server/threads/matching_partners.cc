// Partners: which pairs of sessions are searched at all, once there are too many to search every
// one.
#include <absl/strings/numbers.h>
#include <absl/strings/str_cat.h>
#include <absl/strings/str_split.h>

#include <algorithm>
#include <iterator>
#include <utility>
#include <vector>

#include "server/matching/index/limits.h"
#include "server/threads/limits.h"
#include "server/threads/matching_thread.h"
#include "server/threads/placed_sessions.h"

namespace isthmus::server {

bool MatchingThread::AreSegments(const SessionView& a, const SessionView& b) {
  return a.record.opened() == b.record.opened();
}

bool MatchingThread::SelectsPartners(const MapView& view) {
  const auto count = std::count_if(view.sessions.begin(), view.sessions.end(),
                                   [](const auto& s) { return IsMatchable(s.second); });
  return static_cast<size_t>(count) > matching::kSearchAllSessions;
}

std::optional<SessionId> MatchingThread::NextToIndex(const MapView& view) const {
  if (!SelectsPartners(view)) return std::nullopt;
  for (const auto& [id, session] : view.sessions) {
    if (!IsMatchable(session)) continue;
    const auto it = indexed_.find(id);
    const uint32_t before = it == indexed_.end() ? 0 : it->second, now = session.next_index();
    const bool has_grown = before == 0 ? now >= kMinIndexedSubmaps
                                       : now >= kIndexedGrowth * static_cast<double>(before);
    if (has_grown || (IsFinished(session) && now > before)) return id;
  }
  return std::nullopt;
}

PlanJob MatchingThread::MakePlanJob(const MapView& view, const SessionView& session) {
  const SessionId& id = session.record.id;
  PlanJob job;
  job.session = MakeMapOfJob(id, shapes_.Of(view, session).submaps);
  for (const auto& [other, other_session] : view.sessions) {
    if (other == id || !indexed_.contains(other) || !IsMatchable(other_session)) continue;
    job.others.push_back(MakeMapOfJob(other, shapes_.Of(view, other_session).submaps));
  }
  return job;
}

void MatchingThread::IndexSession(const MapView& view, const SessionId& id) {
  const SessionView& session = *view.Find(id);
  const IndexKey key{id};
  const auto compare = [&] {
    const PlanJob job = MakePlanJob(view, session);
    if (has_workers_) return Post(key, EncodeJob(job));
    TakeScores(id, RunHere<PlanScores>(job));
  };
  indexed_[id] = session.next_index();
  if (!IsSetAside(key)) (void)RunGuarded(key, compare);
  if (!IsPosted(key)) ChoosePartners(view, id);
}

void MatchingThread::ChoosePartners(const MapView& view, const SessionId& session) {
  ranked_ = index_.Rank(matching::kLookedPartners);
  Allowance& allowed = allowed_[session];
  const uint32_t next_index = indexed_[session];
  if (allowed.next_index == next_index) return;  // Chosen before the start: it is due no more.
  allowed = {CountTried(view, PlacedSessions(view))[session], next_index};
  allowed.up_to.pairs += matching::kLookedPartners;
  allowed.up_to.searched += matching::kSearchPartners;
  allowed.up_to.joined += matching::kNearPartners;
  // Where that cannot be stored, or its submap is retired, partners are chosen anew after a start.
  if (next_index == 0) return;
  (void)store_->PutFeatures(
      {{session, next_index - 1},
       kPartnersChosen,
       absl::StrCat(allowed.up_to.pairs, " ", allowed.up_to.searched, " ", allowed.up_to.joined)});
}

void MatchingThread::RestorePartners(const MapView& view) {
  if (!SelectsPartners(view)) return;
  const std::map<SessionId, Tried> all_tried = CountTried(view, PlacedSessions(view));
  for (const auto& [id, session] : view.sessions) {
    const auto found = all_tried.find(id);
    const Tried tried = found == all_tried.end() ? Tried() : found->second;
    if (const std::optional<Allowance> chosen = FindChosen(session)) {
      allowed_[id] = *chosen;
      if (!chosen->HasRoom(tried)) indexed_[id] = chosen->next_index;
    } else if (tried.searched >= matching::kSearchPartners ||
               tried.pairs >= matching::kLookedPartners) {
      indexed_[id] = session.next_index();
    }
  }
}

std::optional<MatchingThread::Allowance> MatchingThread::FindChosen(
    const SessionView& session) const {
  for (const SubmapId& submap : NewestFirst(session)) {
    // From there on it has grown, and they are chosen anew.
    if (kIndexedGrowth * (submap.index + 1) <= session.next_index()) break;
    const absl::StatusOr<std::string> text = store_->GetFeatures(submap, kPartnersChosen);
    if (!text.ok()) continue;
    const std::vector<std::string> numbers = absl::StrSplit(*text, ' ');
    Allowance chosen{{.joined = matching::kNearPartners}, submap.index + 1};
    // Older programs wrote two.
    if (numbers.size() >= 2 && absl::SimpleAtoi(numbers[0], &chosen.up_to.pairs) &&
        absl::SimpleAtoi(numbers[1], &chosen.up_to.searched) &&
        (numbers.size() == 2 || absl::SimpleAtoi(numbers[2], &chosen.up_to.joined))) {
      return chosen;
    }
  }
  return std::nullopt;
}

std::vector<SessionPair> MatchingThread::PairsEndedAt(const MapView& view) const {
  std::vector<SessionPair> pairs;
  for (const std::string& task : journal_.ended_at()) {
    const std::optional<JobKey> key = ParseJobKey(task);
    const auto* match = key ? std::get_if<MatchKey>(&*key) : nullptr;
    if (match != nullptr && !IsGone(view, *key)) pairs.push_back(match->pair);
  }
  return pairs;
}

std::map<SessionId, MatchingThread::Tried> MatchingThread::CountTried(
    const MapView& view, const PlacedSessions& placed) const {
  std::map<SessionId, Tried> count;
  for (const auto& [pair, attempt] : attempts_) {
    const std::shared_ptr<const Match> match = view.matches.Get(pair);
    const bool looked = match != nullptr && match->reason == MatchReason::kNoCandidate;
    const bool joined = placed.AreJoined(pair);
    for (const SessionId& id : {pair.first, pair.second}) {
      ++count[id].pairs;
      if (!looked) ++count[id].searched;
      if (joined) ++count[id].joined;
    }
  }
  return count;
}

std::optional<SessionPair> MatchingThread::NextPartners(const MapView& view) const {
  const PlacedSessions placed(view);
  const auto is_new = [&](const SessionPair& pair) {
    const SessionView *a = view.Find(pair.first), *b = view.Find(pair.second);
    return a != nullptr && b != nullptr && IsMatchable(*a) && IsMatchable(*b) &&
           !attempts_.contains(pair);
  };
  const auto unfinished = std::find_if(unfinished_.begin(), unfinished_.end(), is_new);
  if (unfinished != unfinished_.end()) return *unfinished;
  if (const auto known = NextKnownPartners(view, placed, is_new)) return known;
  std::map<SessionId, Tried> tried = CountTried(view, placed);
  const auto has_room = [&](const SessionId& id) {
    const auto allowed = allowed_.find(id);
    return allowed != allowed_.end() && allowed->second.HasRoom(tried[id]);
  };
  std::optional<SessionPair> apart, joined;
  for (const matching::RankedPair& pair : ranked_) {
    const auto& [a, b] = pair.sessions;
    if (!is_new(pair.sessions) || !(has_room(a) || has_room(b))) continue;
    const bool is_joined = placed.AreJoined(pair.sessions);
    if (!is_joined && (IsAtHand(a) || IsAtHand(b))) return pair.sessions;
    std::optional<SessionPair>& first = is_joined ? joined : apart;
    if (!first) first = pair.sessions;
  }
  if (apart) return apart;
  for (const auto& [id, allowed] : allowed_) {
    if (!allowed.HasRoomNear(tried[id])) continue;
    const auto nearest = placed.NearestJoined(
        id, [&, &id = id](const SessionId& other) { return is_new(std::minmax(id, other)); });
    if (nearest) return std::minmax(id, *nearest);
  }
  return joined;
}

bool MatchingThread::IsAtHand(const SessionId& session) const {
  return last_pair_ && (last_pair_->first == session || last_pair_->second == session);
}

std::optional<SessionPair> MatchingThread::NextKnownPartners(
    const MapView& view, const PlacedSessions& placed,
    const std::function<bool(const SessionPair&)>& is_new) {
  // Few of thousands of sessions have segments or anchors.
  std::vector<const SessionView*> related;
  for (const auto& [id, session] : view.sessions) {
    if (!IsMatchable(session)) continue;
    if (session.record.segment > 1 || placed.IsAnchored(id) ||
        view.Find(SegmentId(id, 2)) != nullptr) {
      related.push_back(&session);
    }
  }
  for (auto a = related.begin(); a != related.end(); ++a) {
    for (auto b = std::next(a); b != related.end(); ++b) {
      const SessionPair pair((*a)->record.id, (*b)->record.id);
      const bool are_near = placed.IsAnchored(pair.first) && placed.IsAnchored(pair.second) &&
                            placed.Nearness(pair) > 0;
      if ((AreSegments(**a, **b) || are_near) && is_new(pair)) return pair;
    }
  }
  return std::nullopt;
}

}  // namespace isthmus::server
