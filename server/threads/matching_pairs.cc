// Pairs: how two sessions' maps lie to each other, and which sessions may have been at one place.
#include <utility>

#include "server/jobs/job_runner.h"
#include "server/threads/anchor_index.h"
#include "server/threads/limits.h"
#include "server/threads/matching_thread.h"

namespace isthmus::server {
namespace {

// True if a newer result takes the place of an older one. An accepted match is only given up for a
// better estimate, for a contradiction, or where it has become doubtful: new submaps may not bear
// it out, and anchors that spoke for it may be gone. A moment of doubt is not enough.
bool Supersedes(const Match& newer, const Match& older) {
  return older.state != MatchState::kAccepted || newer.state == MatchState::kAccepted ||
         newer.state == MatchState::kRejected || newer.confidence < kGivenUpBelow;
}

// The last word on a pair that is still open takes all there is.
bool MustSearch(const MatchTrigger& trigger, const Match* older) {
  const bool accepted = older != nullptr && older->state == MatchState::kAccepted;
  return trigger.last_submaps && !accepted;
}

// Outlines of those that can be read; reads from the store.
JobMapInput MapOf(const MapView& view, const SessionView& session, SessionShapes* shapes) {
  const SessionShapes::Shaped shaped = shapes->Of(view, session);
  JobMapInput map = MakeJobMapInput(session.record.id, shaped.submaps);
  if (shaped.shape) map.shape = *shaped.shape;
  return map;
}

// With the sessions that were compared before.
PlanJob MakePlanJob(const MapView& view, const SessionView& session, const MatchingLedger& ledger,
                    SessionShapes* shapes) {
  const SessionId& id = session.record.id;
  PlanJob job;
  job.session = MakeJobMapInput(id, shapes->Of(view, session).submaps);
  for (const auto& [other, other_session] : view.sessions) {
    if (other == id || !ledger.indexed.contains(other) || !IsMatchable(other_session)) continue;
    job.others.push_back(MakeJobMapInput(other, shapes->Of(view, other_session).submaps));
  }
  return job;
}

}  // namespace

void MatchingThread::IndexSession(const MapView& view, const SessionId& id) {
  const SessionView& session = *view.Find(id);
  const IndexKey key{id};
  ledger_.indexed[id] = session.next_index();
  if (!queue_.IsSetAside(key)) {
    (void)guard_.Run(key, [&] {
      Do(view, key, MakePlanJob(view, session, ledger_, &shapes_), queue_.has_workers());
    });
  }
  if (!ledger_.posted.contains(key)) progress_.ChoosePartners(view, id);
}

void MatchingThread::EstimateMatch(const MapView& view, const SessionPair& pair) {
  const SessionView* session_a = view.Find(pair.first);
  const SessionView* session_b = view.Find(pair.second);
  if (session_a == nullptr || session_b == nullptr) return;
  const std::shared_ptr<const Match> older = view.matches.Get(pair);
  const MatchTrigger trigger = TriggerOf(view, ledger_, pair, schedule_);
  ledger_.attempts[pair] = AttemptNow(view, ledger_, pair);
  ledger_.last_pair = pair;
  if (queue_.IsSetAside(MatchKey{pair})) return;
  const bool done = guard_.Run(MatchKey{pair}, [&] {
    PairJob job = MakePairJob(pair, trigger, older.get());
    job.a = MapOf(view, *session_a, &shapes_);
    job.b = MapOf(view, *session_b, &shapes_);
    job.anchors = AnchorIndex(view).Of(pair);
    if (job.a.submaps.empty() || job.b.submaps.empty()) return;
    Do(view, MatchKey{pair}, std::move(job), queue_.has_workers());
  });
  if (!done) pair_memories_.erase(pair);
}

PairJob MatchingThread::MakePairJob(const SessionPair& pair, const MatchTrigger& trigger,
                                    const Match* older) const {
  PairJob job;
  const auto memory = pair_memories_.find(pair);
  if (memory != pair_memories_.end()) job.memory = memory->second;
  if (job.memory == nullptr && older != nullptr) job.known = *older;
  job.options = options_.matcher;
  job.options.first_look = trigger.first_look;
  job.loops = options_.loops;
  job.search = MustSearch(trigger, older);
  job.posted_ns = clock_->NowNs();
  return job;
}

absl::Status MatchingThread::TakeMatch(const MapView& view, const SessionPair& pair,
                                       const PairResult& result) {
  const Match& match = result.match;
  if (SessionPair(match.a, match.b) != pair) {
    return absl::InternalError("the result is another pair's");
  }
  const std::shared_ptr<const Match> older = view.matches.Get(pair);
  if (older == nullptr || Supersedes(match, *older)) {
    if (absl::Status status = map_->PutMatch(match); !status.ok()) return status;
  }
  pair_memories_[pair] = result.memory;
  return absl::OkStatus();
}

}  // namespace isthmus::server
