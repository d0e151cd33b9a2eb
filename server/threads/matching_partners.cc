// Partners: the comparison of sessions, and how many pairs of each may be searched.
#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "server/matching/index/limits.h"
#include "server/threads/limits.h"
#include "server/threads/matching_thread.h"
#include "server/threads/session_proximity.h"

namespace isthmus::server {

PlanJob MatchingThread::MakePlanJob(const MapView& view, const SessionView& session) {
  const SessionId& id = session.record.id;
  PlanJob job;
  job.session = MakeJobMapInput(id, shapes_.Of(view, session).submaps);
  for (const auto& [other, other_session] : view.sessions) {
    if (other == id || !ledger_.indexed.contains(other) || !IsMatchable(other_session)) continue;
    job.others.push_back(MakeJobMapInput(other, shapes_.Of(view, other_session).submaps));
  }
  return job;
}

void MatchingThread::IndexSession(const MapView& view, const SessionId& id) {
  const SessionView& session = *view.Find(id);
  const IndexKey key{id};
  ledger_.indexed[id] = session.next_index();
  if (!queue_.IsSetAside(key)) {
    (void)guard_.Run(key, [&] { Do(view, key, MakePlanJob(view, session), queue_.has_workers()); });
  }
  if (!ledger_.posted.contains(key)) ChoosePartners(view, id);
}

void MatchingThread::TakeScores(const SessionId& session, const PlanScores& scores) {
  for (const PlanScore& plan : scores) {
    if (plan.score && std::isfinite(*plan.score)) index_.Put(session, plan.other, *plan.score);
  }
}

void MatchingThread::ChoosePartners(const MapView& view, const SessionId& session) {
  ledger_.ranked = index_.Rank(matching::kLookedPartners);
  PairBudget& allowed = ledger_.allowed[session];
  const uint32_t next_index = ledger_.indexed[session];
  if (allowed.next_index == next_index) return;  // Chosen before the start: it is due no more.
  allowed = {CountTried(view, SessionProximity(view), ledger_)[session], next_index};
  allowed.up_to.pairs += matching::kLookedPartners;
  allowed.up_to.searched += matching::kSearchPartners;
  allowed.up_to.joined += matching::kNearPartners;
  storage::MatchingProgress& progress = progress_[session];
  progress = {session,
              progress.next_for_loops,
              next_index,
              allowed.up_to.pairs,
              allowed.up_to.searched,
              allowed.up_to.joined};
  StoreProgress(session);
}

void MatchingThread::RestorePartners(const MapView& view) {
  if (!SelectsPartners(view)) return;
  const std::map<SessionId, PairCounts> all_tried =
      CountTried(view, SessionProximity(view), ledger_);
  for (const auto& [id, session] : view.sessions) {
    const auto found = all_tried.find(id);
    const PairCounts tried = found == all_tried.end() ? PairCounts() : found->second;
    if (const std::optional<PairBudget> chosen = FindChosen(session)) {
      ledger_.allowed[id] = *chosen;
      if (!chosen->HasRoom(tried)) ledger_.indexed[id] = chosen->next_index;
    } else if (tried.searched >= matching::kSearchPartners ||
               tried.pairs >= matching::kLookedPartners) {
      ledger_.indexed[id] = session.next_index();
    }
  }
}

std::optional<PairBudget> MatchingThread::FindChosen(const SessionView& session) const {
  const auto found = progress_.find(session.record.id);
  if (found == progress_.end() || found->second.next_at_choice == 0) return std::nullopt;
  const storage::MatchingProgress& progress = found->second;
  // It has grown since, and they are chosen anew.
  if (kIndexedGrowth * progress.next_at_choice <= session.next_index()) return std::nullopt;
  return PairBudget{{progress.max_pairs, progress.max_searched, progress.max_joined},
                    progress.next_at_choice};
}

std::vector<SessionPair> MatchingThread::PairsEndedAt(const MapView& view) const {
  std::vector<SessionPair> pairs;
  for (const JobKey& key : guard_.ended_at()) {
    const auto* match = std::get_if<MatchKey>(&key);
    if (match == nullptr || view.Find(match->pair.first) == nullptr ||
        view.Find(match->pair.second) == nullptr) {
      continue;
    }
    pairs.push_back(match->pair);
  }
  return pairs;
}

}  // namespace isthmus::server
