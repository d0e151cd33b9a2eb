#include "server/threads/stored_progress.h"

#include <absl/strings/str_cat.h>

#include <algorithm>

#include "server/matching/index/limits.h"
#include "server/threads/limits.h"
#include "server/threads/matching_schedule.h"
#include "server/threads/session_proximity.h"

namespace isthmus::server {

StoredProgress::StoredProgress(storage::MapStore* store, MatchingLedger* ledger,
                               const std::function<void(const std::string& problem)>& on_problem)
    : store_(store), ledger_(ledger) {
  const auto stored = store->ListMatchingProgress();
  if (!stored.ok()) {
    on_problem(absl::StrCat("matching begins anew, as its progress cannot be read: ",
                            stored.status().message()));
    return;
  }
  for (const storage::MatchingProgress& progress : *stored) {
    by_session_[progress.session] = progress;
  }
}

void StoredProgress::Store(const storage::MatchingProgress& progress) {
  // Without it some work is done again after the next start.
  (void)store_->Write({.matching_progress = {progress}});
}

uint32_t StoredProgress::FirstUnsearched(const SessionView& session) const {
  const auto progress = by_session_.find(session.record.id);
  if (progress == by_session_.end()) return 0;
  return std::min(progress->second.next_for_loops, session.next_index());
}

void StoredProgress::NoteSearched(const SubmapId& submap) {
  storage::MatchingProgress& progress = by_session_[submap.session];
  progress.session = submap.session;
  progress.next_for_loops = submap.index + 1;
  Store(progress);
}

void StoredProgress::ChoosePartners(const MapView& view, const SessionId& session) {
  PairBudget& allowed = ledger_->allowed[session];
  const uint32_t next_index = ledger_->indexed[session];
  if (allowed.next_index == next_index) return;  // Chosen before the start: it is due no more.
  allowed = {CountTried(view, SessionProximity(view), *ledger_)[session], next_index};
  allowed.up_to.pairs += matching::kLookedPartners;
  allowed.up_to.searched += matching::kSearchPartners;
  allowed.up_to.joined += matching::kNearPartners;
  storage::MatchingProgress& progress = by_session_[session];
  progress = {session,
              progress.next_for_loops,
              next_index,
              allowed.up_to.pairs,
              allowed.up_to.searched,
              allowed.up_to.joined};
  Store(progress);
}

void StoredProgress::RestorePartners(const MapView& view) const {
  if (!SelectsPartners(view)) return;
  const std::map<SessionId, PairCounts> all_tried =
      CountTried(view, SessionProximity(view), *ledger_);
  for (const auto& [id, session] : view.sessions) {
    const auto found = all_tried.find(id);
    const PairCounts tried = found == all_tried.end() ? PairCounts() : found->second;
    if (const std::optional<PairBudget> chosen = FindChosen(session)) {
      ledger_->allowed[id] = *chosen;
      if (!chosen->HasRoom(tried)) ledger_->indexed[id] = chosen->next_index;
    } else if (tried.searched >= matching::kSearchPartners ||
               tried.pairs >= matching::kLookedPartners) {
      ledger_->indexed[id] = session.next_index();
    }
  }
}

std::optional<PairBudget> StoredProgress::FindChosen(const SessionView& session) const {
  const auto found = by_session_.find(session.record.id);
  if (found == by_session_.end() || found->second.next_at_choice == 0) return std::nullopt;
  const storage::MatchingProgress& progress = found->second;
  // It has grown since, and they are chosen anew.
  if (kIndexedGrowth * progress.next_at_choice <= session.next_index()) return std::nullopt;
  return PairBudget{{progress.max_pairs, progress.max_searched, progress.max_joined},
                    progress.next_at_choice};
}

void StoredProgress::ForgetIf(const std::function<bool(const SessionId& session)>& is_gone) {
  std::erase_if(by_session_, [&](const auto& item) { return is_gone(item.first); });
}

}  // namespace isthmus::server
