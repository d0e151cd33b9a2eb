// Jobs: matches that workers compute, on the board of the store.
#include <absl/strings/str_cat.h>

#include <optional>
#include <utility>
#include <vector>

#include "server/jobs/pair_job.h"
#include "server/threads/limits.h"
#include "server/threads/matching_thread.h"

namespace isthmus::server {
namespace {

MapOfJob JobMapOf(const ShapedMap& shaped) {
  MapOfJob map;
  map.session = shaped.map.session;
  for (const auto& submap : shaped.map.submaps) {
    map.submaps.push_back(submap->id.index);
    map.stamps_ns.push_back(submap->first_stamp_ns);
    map.T_odom_submap.push_back(submap->T_odom_submap);
  }
  if (shaped.shape) map.shape = *shaped.shape;
  return map;
}

// Of trouble that passes.
bool IsForNow(const absl::Status& status) {
  return absl::IsUnavailable(status) || absl::IsResourceExhausted(status);
}

}  // namespace

std::string MatchingThread::TaskOf(const SessionPair& pair) {
  return absl::StrCat("the match of ", pair.first.value(), " and ", pair.second.value());
}

void MatchingThread::PostMatch(const ShapedMap& a, const ShapedMap& b, std::vector<Anchor> anchors,
                               const Occasion& occasion, const Match* older) {
  const SessionPair pair(a.map.session, b.map.session);
  PairJob job{.a = JobMapOf(a), .b = JobMapOf(b), .anchors = std::move(anchors)};
  if (older != nullptr) job.known = *older;
  job.options = options_.matcher;
  job.search = MustSearch(occasion, older);
  job.posted_ns = clock_->NowNs();
  matchers_.erase(pair);  // Of when there were no workers.
  const absl::Status status = board_->Post({TaskOf(pair), EncodePairJob(job)});
  if (status.ok()) {
    posted_[TaskOf(pair)] = {pair, occasion};
  } else if (absl::IsFailedPrecondition(status)) {
    TellLeftOut(TaskOf(pair), std::string(status.message()));
  } else {
    attempts_.erase(pair);
    has_workers_ = false;  // Until they are looked for again.
  }
}

void MatchingThread::AdoptJobs(const MapView& view) {
  if (board_ == nullptr) return;
  const auto open = board_->ListOpen();
  if (!open.ok()) return;  // What is posted anew takes their places.
  for (const storage::PostedJob& posted : *open) {
    const absl::StatusOr<PairJob> job = DecodePairJob(posted.payload);
    if (!job.ok()) continue;
    const SessionPair pair(job->a.session, job->b.session);
    const SessionView *a = view.Find(pair.first), *b = view.Find(pair.second);
    if (a == nullptr || b == nullptr) continue;
    attempts_[pair] = AttemptOf(view, *a, *b, static_cast<uint32_t>(job->a.submaps.size()),
                                static_cast<uint32_t>(job->b.submaps.size()), job->posted_ns);
    posted_[posted.key] = {pair, {}};
  }
}

void MatchingThread::FollowWorkers(const MapView& view) {
  if (board_ == nullptr) return;
  const auto is_due = [](const std::optional<Stopwatch>& looked, double every_ms) {
    return !looked || looked->Ms() >= every_ms;
  };
  if (!looked_for_results_ ||
      (!posted_.empty() && is_due(looked_for_results_, kLookForResultsMs))) {
    looked_for_results_.emplace();
    TakeResults(view);
  }
  if (is_due(looked_for_workers_, kLookForWorkersMs)) {
    looked_for_workers_.emplace();
    const absl::StatusOr<int64_t> count = board_->CountWorkers();
    if (count.ok()) workers_ = static_cast<uint64_t>(*count);
    has_workers_ = workers_ > 0;
    if (count.ok() && !has_workers_ && !posted_.empty()) WithdrawJobs();
  }
  posted_count_ = posted_.size();
}

void MatchingThread::TakeResults(const MapView& view) {
  const auto ended = board_->ListEnded();
  if (!ended.ok()) return;
  std::vector<storage::EndedJob> taken;
  for (const storage::EndedJob& job : *ended) {
    const auto it = posted_.find(job.key);
    const std::optional<Posted> posted =
        it == posted_.end() ? std::nullopt : std::optional(it->second);
    const bool is_gone = posted && (view.Find(posted->pair.first) == nullptr ||
                                    view.Find(posted->pair.second) == nullptr);
    const absl::Status status =
        is_gone ? absl::OkStatus() : TakeResult(view, job, posted ? posted->occasion : Occasion());
    if (IsForNow(status)) continue;  // It stays on the board.
    if (!status.ok()) {
      const bool is_first = TellLeftOut(job.key, std::string(status.message()));
      // Its submaps may have been retired while it waited; a second time it is something else.
      if (is_first && !job.is_set_aside && posted) attempts_.erase(posted->pair);
    }
    if (posted) posted_.erase(it);
    taken.push_back(job);
  }
  // What stays there is taken again, and nothing comes of it.
  (void)board_->Remove(taken);
}

absl::Status MatchingThread::TakeResult(const MapView& view, const storage::EndedJob& job,
                                        const Occasion& occasion) {
  if (!job.problem.empty()) return absl::InternalError(job.problem);
  const absl::StatusOr<Match> match = DecodeMatch(job.result);
  if (!match.ok()) return match.status();
  const SessionPair pair(match->a, match->b);
  const SessionView *a = view.Find(pair.first), *b = view.Find(pair.second);
  if (a == nullptr || b == nullptr) return absl::OkStatus();  // Deleted meanwhile.
  if (!IsPosted(pair)) {                                      // By an earlier server.
    attempts_[pair] =
        AttemptOf(view, *a, *b, match->submaps_a, match->submaps_b, match->computed_ns);
  }
  return TakeMatch(*match, view.matches.Get(pair).get(), occasion);
}

void MatchingThread::WithdrawJobs() {
  if (!board_->Withdraw().ok()) return;
  for (const auto& [task, posted] : posted_) attempts_.erase(posted.pair);
  posted_.clear();
  looked_for_results_.reset();  // One may have been finished meanwhile.
}

}  // namespace isthmus::server
