// Jobs: done here or by workers, and taken into the map.
#include <cmath>
#include <optional>
#include <variant>

#include "core/caught.h"
#include "server/jobs/job.h"
#include "server/matching/index/limits.h"
#include "server/threads/matching_thread.h"

namespace isthmus::server {

void MatchingThread::Do(const MapView& view, const JobKey& key, const Job& job, bool by_workers) {
  if (by_workers) return queue_.Post(key, job);
  const JobResult result = RunHere(job);
  AwaitStored([&] { return Take(view, key, result); });
}

JobResult MatchingThread::RunHere(const Job& job) {
  std::optional<StageTimer> timer;
  if (std::holds_alternative<PairJob>(job)) timer.emplace(activity_->observer(), Stage::kMatch);
  if (std::holds_alternative<LoopJob>(job)) {
    timer.emplace(activity_->observer(), Stage::kLoopSearch);
  }
  absl::StatusOr<JobResult> result = runner_.Run(job, stop_.get_token());
  prepared_bytes_ = runner_.prepared_bytes();
  if (stop_.stop_requested()) throw Stopped();
  const auto* loops = std::get_if<LoopJob>(&job);
  if (loops != nullptr && runner_.has_left_out()) has_gaps_.insert(loops->session.session);
  if (!result.ok()) throw StatusError(result.status());
  return *std::move(result);
}

void MatchingThread::AwaitStored(const std::function<absl::Status()>& write) const {
  while (true) {
    const absl::Status status = write();
    if (status.ok()) return;
    // Nobody finds it a second time before the next start, and without it the map would settle.
    if (!absl::IsUnavailable(status) && !absl::IsResourceExhausted(status)) {
      throw StatusError(status);
    }
    if (stop_.stop_requested()) throw Stopped();
    LookAgainSoon();
  }
}

absl::Status MatchingThread::TakeEnded(const MapView& view, const JobKey& key,
                                       const JobResult& result) {
  if (absl::Status status = Take(view, key, result); !status.ok()) return status;
  if (const auto* index = std::get_if<IndexKey>(&key))
    progress_.ChoosePartners(view, index->session);
  const auto* match = std::get_if<MatchKey>(&key);
  if (match != nullptr && !ledger_.posted.contains(key)) {
    const Match& made = std::get<PairResult>(result).match;
    ledger_.attempts[match->pair] =
        AttemptOf(view, match->pair, made.submaps_a, made.submaps_b, made.computed_ns);
  }
  return absl::OkStatus();
}

absl::Status MatchingThread::Take(const MapView& view, const JobKey& key, const JobResult& result) {
  if (const auto* match = std::get_if<PairResult>(&result)) {
    return TakeMatch(view, std::get<MatchKey>(key).pair, *match);
  }
  if (const auto* loops = std::get_if<LoopResult>(&result)) {
    return TakeLoops(std::get<LoopKey>(key).submap, *loops);
  }
  for (const PlanScore& plan : std::get<PlanScores>(result)) {
    if (!plan.score || !std::isfinite(*plan.score)) continue;
    index_.Put(std::get<IndexKey>(key).session, plan.other, *plan.score);
  }
  ledger_.ranked = index_.Rank(matching::kLookedPartners);
  return absl::OkStatus();
}

}  // namespace isthmus::server
