#include "server/threads/matching_ledger.h"

#include <utility>
#include <variant>

namespace isthmus::server {

void MatchingLedger::Forget(const JobKey& key) {
  if (const auto* match = std::get_if<MatchKey>(&key)) {
    attempts.erase(match->pair);
  } else if (const auto* index = std::get_if<IndexKey>(&key)) {
    indexed.erase(index->session);
  } else if (const auto* loops = std::get_if<LoopKey>(&key)) {
    const SubmapId& submap = loops->submap;
    // If the session went on without it, a later submap closes the loop too.
    const auto next = looped.find(submap.session);
    if (next != looped.end() && next->second == submap.index + 1) next->second = submap.index;
  }
}

void MatchingLedger::ForgetGone(const storage::MapRecords& view) {
  const auto is_gone = [&view](const auto& item) {
    return view.sessions.Find(item.first) == nullptr;
  };
  std::erase_if(attempts, [&](const auto& item) {
    const auto& [a, b] = item.first;
    return view.sessions.Find(a) == nullptr || view.sessions.Find(b) == nullptr;
  });
  std::erase_if(looped, is_gone);
  std::erase_if(indexed, is_gone);
  std::erase_if(allowed, is_gone);
  std::erase_if(shapes, is_gone);
}

}  // namespace isthmus::server
