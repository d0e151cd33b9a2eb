#include "fleet/worker/site_worker.h"

#include <absl/time/clock.h>
#include <absl/time/time.h>

#include <utility>

#include "core/caught.h"
#include "core/concurrency/thread_role.h"
#include "core/stopwatch.h"
#include "fleet/postgresql/limits.h"

namespace isthmus::server {

SiteWorker::SiteWorker(std::unique_ptr<storage::MapStore> store,
                       std::unique_ptr<storage::JobTaker> taker, const JobRunner::Options& options)
    : store_(std::move(store)),
      taker_(std::move(taker)),
      options_(options),
      signs_([this] { GiveSigns(); }) {}

SiteWorker::~SiteWorker() {
  {
    MutexLock lock(&mutex_);
    is_ending_ = true;
    changed_.SignalAll();
  }
  signs_.join();
}

absl::StatusOr<std::unique_ptr<SiteWorker>> SiteWorker::Open(const std::string& url,
                                                             const std::string& site,
                                                             const std::string& name,
                                                             const JobRunner::Options& options) {
  auto store = storage::OpenWorkerStore(url, site);
  if (!store.ok()) return store.status();
  auto taker = storage::JobTaker::Open(url, site, name);
  if (!taker.ok()) return taker.status();
  return std::unique_ptr<SiteWorker>(new SiteWorker(*std::move(store), *std::move(taker), options));
}

void SiteWorker::GiveSigns() {
  NameThread("signs");
  while (true) {
    std::optional<storage::TakenJob> job;
    {
      MutexLock lock(&mutex_);
      if (!is_ending_) {
        changed_.WaitWithDeadline(&mutex_, absl::Now() + absl::FromChrono(storage::kWorkerSign));
      }
      if (is_ending_) return;
      if (at_hand_) job = storage::TakenJob{at_hand_->id, at_hand_->attempt, {}, {}, 0};
    }
    const absl::StatusOr<bool> is_ours = taker_->KeepAlive(job);
    MutexLock lock(&mutex_);
    sign_ = is_ours.status();
    if (!is_ours.ok() || *is_ours) continue;  // Away, it may be back before the lease ends.
    if (at_hand_ && at_hand_->id == job->id && at_hand_->attempt == job->attempt) {
      lost_.request_stop();
    }
  }
}

absl::StatusOr<std::string> SiteWorker::Compute(const storage::TakenJob& job,
                                                std::stop_token stop) {
  try {
    return runner_->Run(job.payload, std::move(stop));
  } catch (...) {
    return CaughtStatus();
  }
}

absl::StatusOr<std::optional<SiteWorker::Done>> SiteWorker::RunOne(std::stop_token stop) {
  {
    MutexLock lock(&mutex_);
    if (!sign_.ok()) return sign_;
  }
  if (pending_result_) return Deliver();
  absl::StatusOr<std::optional<storage::TakenJob>> taken = taker_->Take();
  if (!taken.ok()) return taken.status();
  if (!*taken) return std::nullopt;
  const storage::TakenJob job = **std::move(taken);
  // Known submaps may be others by now, if the database was set back meanwhile.
  if (!runner_ || connection_ != job.connection) runner_.emplace(store_.get(), options_);
  connection_ = job.connection;
  std::stop_source lost;
  {
    MutexLock lock(&mutex_);
    at_hand_ = job;
    lost_ = lost;
  }
  const Stopwatch watch;
  const std::stop_callback end(stop, [&lost] { lost.request_stop(); });
  absl::StatusOr<std::string> result = Compute(job, lost.get_token());
  pending_result_ = {job, std::move(result), watch.Ms() / 1000};
  return Deliver();
}

absl::StatusOr<std::optional<SiteWorker::Done>> SiteWorker::Deliver() {
  const auto& [job, result, seconds] = *pending_result_;
  const absl::Status& status = result.status();
  const absl::StatusOr<bool> is_ours = result.ok() ? taker_->Finish(job, *result)
                                       : absl::IsUnavailable(status) || absl::IsCancelled(status)
                                           ? taker_->GiveBack(job)
                                           : taker_->Fail(job, std::string(status.message()));
  const absl::Status& way = is_ours.status();
  if (absl::IsUnavailable(way) || absl::IsResourceExhausted(way)) return way;  // This error passes.
  Done done{job.key, status, seconds};
  if (way.ok() && !*is_ours) done.status = absl::AbortedError("it was another's, or withdrawn");
  pending_result_.reset();
  {
    MutexLock lock(&mutex_);
    at_hand_.reset();
  }
  if (!way.ok()) return way;  // Others take it, once its lease has ended.
  if (absl::IsUnavailable(done.status)) return done.status;
  return done;
}

}  // namespace isthmus::server
