// The progress of matching as it is stored, so that a server that starts goes on there.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>

#include "server/map/map_view.h"
#include "server/threads/matching_ledger.h"
#include "storage/map_store.h"

namespace isthmus::server {

// Each session's submaps searched for loops, and pairs of it that may be tried with partners. For
// the thread that has the ledger.
class StoredProgress {
 public:
  // Reads it; tells where it cannot, and matching begins anew.
  StoredProgress(storage::MapStore* store, MatchingLedger* ledger,
                 const std::function<void(const std::string& problem)>& on_problem);

  // The first submap to search for loops.
  uint32_t FirstUnsearched(const SessionView& session) const;
  void NoteSearched(const SubmapId& submap);
  // Chooses the session's partners, now that its scores are there.
  void ChoosePartners(const MapView& view, const SessionId& session);
  // As they were chosen before the start.
  void RestorePartners(const MapView& view) const;
  void ForgetIf(const std::function<bool(const SessionId& session)>& is_gone);

 private:
  std::optional<PairBudget> FindChosen(const SessionView& session) const;
  void Store(const storage::MatchingProgress& progress);

  storage::MapStore* const store_;
  MatchingLedger* const ledger_;
  std::map<SessionId, storage::MatchingProgress> by_session_;
};

}  // namespace isthmus::server
