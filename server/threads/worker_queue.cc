#include "server/threads/worker_queue.h"

#include <absl/strings/str_cat.h>

#include <algorithm>
#include <utility>
#include <variant>
#include <vector>

#include "server/jobs/limits.h"
#include "server/threads/matching_schedule.h"

namespace isthmus::server {
namespace {

// The map is of the session as it is there, less what was retired.
bool IsOf(const MapView& view, const JobMapInput& map) {
  const SessionView* session = view.Find(map.session);
  if (session == nullptr) return false;
  bool is_there = false;
  for (size_t k = 0; k < map.submaps.size(); ++k) {
    const SubmapInfo* submap = session->submaps.Find(map.submaps[k]);
    if (submap == nullptr) continue;
    if (submap->first_stamp_ns != map.stamps_ns[k]) return false;
    is_there = true;
  }
  return is_there;
}

bool IsOf(const MapView& view, const PairJob& job) {
  return IsOf(view, job.a) && IsOf(view, job.b);
}
bool IsOf(const MapView& view, const PlanJob& job) { return IsOf(view, job.session); }
bool IsOf(const MapView& view, const LoopJob& job) { return IsOf(view, job.session); }

// A session of it was deleted.
bool IsGone(const MapView& view, const JobKey& key) {
  const std::vector<SessionId> sessions = SessionsOf(key);
  return std::any_of(sessions.begin(), sessions.end(),
                     [&view](const SessionId& id) { return view.Find(id) == nullptr; });
}

// The job in the queue; nothing where it is damaged, or of submaps that are not there: those of a
// deleted session, whose id may be another's by now.
std::optional<Job> ReadJob(const MapView& view, const storage::QueuedJob& job) {
  absl::StatusOr<Job> made = DecodeJob(job.payload);
  if (!made.ok() || ToText(KeyOfJob(*made)) != job.key) return std::nullopt;
  const bool is_of = std::visit([&](const auto& record) { return IsOf(view, record); }, *made);
  if (!is_of) return std::nullopt;
  return *std::move(made);
}

// True for trouble that passes.
bool IsForNow(const absl::Status& status) {
  return absl::IsUnavailable(status) || absl::IsResourceExhausted(status);
}

}  // namespace

WorkerQueue::WorkerQueue(storage::JobQueue* queue, MatchingLedger* ledger, WorkGuard* guard,
                         Hooks hooks)
    : queue_(queue), ledger_(ledger), guard_(guard), hooks_(std::move(hooks)) {}

bool WorkerQueue::WantsLoops(uint64_t waiting_submaps) const {
  const bool are_busy = took_loops_back_ && took_loops_back_->Ms() < kLoopsAtHomeMs;
  return has_workers_ && !are_busy && waiting_submaps > kLoopsAtHome &&
         ledger_->posted.size() < 2 * kMaxPostedJobs;
}

void WorkerQueue::Post(const JobKey& key, const Job& job) {
  const bool is_urgent = std::holds_alternative<LoopJob>(job);
  const absl::Status status = queue_->Post({ToText(key), EncodeJob(job), is_urgent});
  if (status.ok()) {
    set_aside_.erase(key);
    ledger_->posted.insert_or_assign(key, Stopwatch());
  } else if (absl::IsFailedPrecondition(status)) {
    SetAside(key, std::string(status.message()));
  } else {
    TellOfTrouble("jobs cannot be given to workers", status);
    ledger_->Forget(key);
    has_workers_ = false;  // Until they are looked for again.
  }
}

void WorkerQueue::TellOfTrouble(const std::string& what, const absl::Status& status) {
  const std::string problem = absl::StrCat(what, ": ", status.message());
  if (absl::IsUnavailable(status) || !told_.insert(problem).second) return;
  hooks_.on_problem(problem);
}

void WorkerQueue::SetAside(const JobKey& key, const std::string& problem) {
  (void)guard_->Tell(key, problem);
  set_aside_.insert(key);
}

void WorkerQueue::Adopt(const MapView& view) {
  if (queue_ == nullptr) return;
  const auto jobs = queue_->ListAll();
  if (!jobs.ok()) return;  // Jobs that are posted anew take their places.
  for (const storage::QueuedJob& job : *jobs) {
    const std::optional<Job> made = ReadJob(view, job);
    const auto* pair = made ? std::get_if<PairJob>(&*made) : nullptr;
    if (made && job.is_set_aside) {
      SetAside(KeyOfJob(*made),
               "workers ended while they were at it; see its row in the table jobs");
    } else if (pair != nullptr) {
      const SessionPair sessions(pair->a.session, pair->b.session);
      ledger_->attempts[sessions] =
          AttemptOf(view, sessions, static_cast<uint32_t>(pair->a.submaps.size()),
                    static_cast<uint32_t>(pair->b.submaps.size()), pair->posted_ns);
      ledger_->posted.emplace(KeyOfJob(*made), Stopwatch());
    } else {
      // Sessions are all compared, and submaps searched for loops, anew.
      (void)queue_->Drop(job.key);
    }
  }
  counts_.set_aside = set_aside_.size();
}

void WorkerQueue::Follow(const MapView& view) {
  if (queue_ == nullptr) return;
  const auto is_due = [](const std::optional<Stopwatch>& looked, double every_ms) {
    return !looked || looked->Ms() >= every_ms;
  };
  if (!looked_for_results_ ||
      (!ledger_->posted.empty() && is_due(looked_for_results_, kLookForResultsMs))) {
    looked_for_results_.emplace();
    TakeResults(view);
    TakeBackLoops();
  }
  if (is_due(looked_for_workers_, kLookForWorkersMs)) {
    looked_for_workers_.emplace();
    CountWorkers();
    ForgetMissing();
    RemoveGone(view);
  }
  counts_.posted = ledger_->posted.size();
  counts_.set_aside = set_aside_.size();
}

void WorkerQueue::CountWorkers() {
  const absl::StatusOr<storage::WorkerCount> count = queue_->CountWorkers();
  counts_.workers = count.ok() ? static_cast<uint64_t>(count->able) : 0;
  has_workers_ = counts_.workers > 0;
  if (!has_workers_ && !ledger_->posted.empty()) WithdrawJobs();
  if (!count.ok()) return TellOfTrouble("workers cannot be counted", count.status());
  const bool has_others = count->of_other_versions > 0;
  if (has_others && !told_of_other_versions_) {
    hooks_.on_problem(absl::StrCat(count->of_other_versions,
                                   " workers are of another version than the server and do none "
                                   "of its jobs; start those of its own"));
  }
  told_of_other_versions_ = has_others;
}

void WorkerQueue::ForgetMissing() {
  if (ledger_->posted.empty() && set_aside_.empty()) return;
  const auto keys = queue_->ListKeys();
  if (!keys.ok()) return;
  const auto forget_if_missing = [&](const JobKey& key) {
    if (keys->contains(ToText(key))) return false;
    guard_->TellAgain(key);
    hooks_.on_due();
    ledger_->Forget(key);
    return true;
  };
  std::erase_if(ledger_->posted, [&](const auto& job) { return forget_if_missing(job.first); });
  std::erase_if(set_aside_, forget_if_missing);
}

void WorkerQueue::TakeBackLoops() {
  std::erase_if(ledger_->posted, [this](const auto& job) {
    const auto& [key, since] = job;
    if (!std::holds_alternative<LoopKey>(key) || since.Ms() < kLoopsUntakenMs) return false;
    const absl::StatusOr<bool> was_nobodys = queue_->TakeBack(ToText(key));
    if (!was_nobodys.ok() || !*was_nobodys) return false;
    took_loops_back_.emplace();
    ledger_->Forget(key);
    return true;
  });
}

void WorkerQueue::RemoveGone(const MapView& view) {
  const auto drop_if_gone = [&](const JobKey& key) {
    return IsGone(view, key) && queue_->Drop(ToText(key)).ok();
  };
  std::erase_if(ledger_->posted, [&](const auto& job) { return drop_if_gone(job.first); });
  std::erase_if(set_aside_, drop_if_gone);
}

void WorkerQueue::TakeResults(const MapView& view) {
  const auto ended = queue_->ListEnded();
  if (!ended.ok()) return;
  std::vector<storage::EndedJob> taken;
  for (const storage::EndedJob& job : *ended) {
    if (const std::optional<JobKey> key = ParseJobKey(job.key)) {
      const absl::Status status = TakeEnded(view, *key, job);
      if (IsForNow(status)) continue;  // It stays in the queue.
      Finish(*key, job, status);
    }
    taken.push_back(job);
  }
  // Jobs that stay there are taken again, and nothing comes of it.
  (void)queue_->Remove(taken);
}

void WorkerQueue::Finish(const JobKey& key, const storage::EndedJob& job,
                         const absl::Status& status) {
  const bool was_posted = ledger_->posted.erase(key) > 0;
  if (status.ok()) return;
  if (was_posted) hooks_.on_failed(key);
  if (job.is_set_aside) {
    if (was_posted) SetAside(key, job.problem);
    return;
  }
  // Its submaps may have been retired while it waited; a second time it is something else.
  if (guard_->Tell(key, std::string(status.message())) && was_posted) ledger_->Forget(key);
}

absl::Status WorkerQueue::TakeEnded(const MapView& view, const JobKey& key,
                                    const storage::EndedJob& job) {
  const bool is_gone = IsGone(view, key);
  if (is_gone && !job.is_set_aside) return absl::OkStatus();
  if (is_gone || !job.problem.empty()) return absl::InternalError(job.problem);
  // Posted by an earlier server: outdated, but for a match.
  if (!ledger_->posted.contains(key) && !std::holds_alternative<MatchKey>(key)) {
    return absl::OkStatus();
  }
  const absl::StatusOr<JobResult> result = DecodeResult(key, job.result);
  return result.ok() ? hooks_.take(view, key, *result) : result.status();
}

void WorkerQueue::WithdrawJobs() {
  if (!queue_->Withdraw().ok()) return;
  // Jobs that were set aside, or finished meanwhile, stay: the next look at ended jobs tells.
  const auto left = queue_->ListKeys();
  if (!left.ok()) return;  // See ForgetMissing.
  std::erase_if(ledger_->posted, [&](const auto& job) {
    if (left->contains(ToText(job.first))) return false;
    ledger_->Forget(job.first);
    return true;
  });
  looked_for_results_.reset();
}

}  // namespace isthmus::server
