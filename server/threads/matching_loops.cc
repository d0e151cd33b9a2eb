// Loop closures: where a session came back to a place.
#include <utility>
#include <vector>

#include "server/threads/limits.h"
#include "server/threads/matching_thread.h"

namespace isthmus::server {

void MatchingThread::FindLoops(const MapView& view, const SubmapId& submap) {
  ledger_.looped[submap.session] = submap.index + 1;
  const SessionView* entry = view.Find(submap.session);
  const Placement* placement = view.PlacementOf(submap.session);
  if (entry == nullptr || placement == nullptr) return;
  if (queue_.IsSetAside(LoopKey{submap})) {
    has_gaps_.insert(submap.session);
    return;
  }
  const bool was_last = IsFinished(*entry) && submap.index + 1 == entry->next_index();
  const bool done = guard_.Run(LoopKey{submap}, [&] {
    LoopJob job = MakeLoopJob(view, submap, *entry, *placement);
    if (job.session.submaps.empty() || job.session.submaps.back() != submap.index) return;
    // With workers the next submap of the session waits for what comes of it.
    Do(view, LoopKey{submap}, std::move(job), queue_.WantsLoops(waiting_submaps_));
  });
  if (!done) has_gaps_.insert(submap.session);
  if (!was_last && done) return;
  memories_.erase(submap.session);
  // The runner's finder of the session is large.
  runner_.ForgetIf([&](const SessionId& session) { return session == submap.session; });
}

LoopJob MatchingThread::MakeLoopJob(const MapView& view, const SubmapId& submap,
                                    const SessionView& session, const Placement& placement) const {
  LoopJob job;
  job.session.session = submap.session;
  for (const SubmapPose& pose : placement.submaps) {
    const SubmapInfo* info = session.submaps.Find(pose.index);
    if (pose.index > submap.index || info == nullptr) continue;
    job.session.submaps.push_back(pose.index);
    job.session.stamps_ns.push_back(info->first_stamp_ns);
    job.session.T_odom_submap.push_back(info->T_odom_submap);
    job.T_map_submap.push_back(pose.T_map_submap);
  }
  job.first_new = job.session.submaps.empty() ? 0 : job.session.submaps.size() - 1;
  for (const auto& [id, loop] : view.loops) {
    if (loop.session == submap.session) job.known.push_back(loop);
  }
  const auto memory = memories_.find(submap.session);
  if (memory != memories_.end()) job.memory = memory->second;
  job.options = options_.loops;
  return job;
}

absl::Status MatchingThread::TakeLoops(const SubmapId& submap, const LoopResult& result) {
  for (const LoopClosure& loop : result.found) {
    if (loop.session != submap.session) return absl::InternalError("of another session");
  }
  absl::Status status = map_->AddLoops(result.found);
  if (!status.ok()) return status;
  // It would say so of one that was left out before it.
  if (!has_gaps_.contains(submap.session)) progress_.NoteSearched(submap);
  memories_[submap.session] = result.memory;
  return status;
}

}  // namespace isthmus::server
