// A worker of one site: takes its jobs, does them one by one, leaves the results.
#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <thread>

#include "core/concurrency/mutex.h"
#include "fleet/postgresql/worker_store.h"
#include "server/jobs/job_runner.h"
#include "storage/map_store.h"

namespace isthmus::server {

// While the object lives the site's server knows of the worker, by a thread that gives signs of
// life. Not thread safe.
class SiteWorker {
 public:
  // Errors as OpenWorkerStore and JobTaker::Open. `name` is one that no other worker has.
  static absl::StatusOr<std::unique_ptr<SiteWorker>> Open(const std::string& url,
                                                          const std::string& site,
                                                          const std::string& name,
                                                          const JobRunner::Options& options);
  ~SiteWorker();

  struct Done {
    std::string key;
    absl::Status status;  // The job's; an error says why there is no result.
    double seconds = 0;
  };
  // Does a job; nothing if there is none. A job that is under way when `stop` is requested is given
  // back, for another worker. Errors are of the way to the database: the job's result then is kept,
  // and brought by the next call. While the last sign of life could not be given no job is taken,
  // as nobody knows of the worker.
  absl::StatusOr<std::optional<Done>> RunOne(std::stop_token stop);

  // There is a result that could not be written yet.
  bool owes() const { return pending_result_.has_value(); }

 private:
  SiteWorker(std::unique_ptr<storage::MapStore> store, std::unique_ptr<storage::JobTaker> taker,
             const JobRunner::Options& options);
  void GiveSigns();
  // The result's bytes.
  absl::StatusOr<std::string> Compute(const storage::TakenJob& job, std::stop_token stop);
  // A result that is not in the queue yet: else the database's bad moments, a full disk, would
  // count as deaths of workers.
  struct PendingResult {
    storage::TakenJob job;
    absl::StatusOr<std::string> result;
    double seconds = 0;
  };
  absl::StatusOr<std::optional<Done>> Deliver();

  const std::unique_ptr<storage::MapStore> store_;
  const std::unique_ptr<storage::JobTaker> taker_;
  const JobRunner::Options options_;
  std::optional<JobRunner> runner_;
  int64_t connection_ = 0;  // The last job came over it.
  std::optional<PendingResult> pending_result_;
  Mutex mutex_;
  CondVar changed_;
  bool is_ending_ ABSL_GUARDED_BY(mutex_) = false;
  absl::Status sign_ ABSL_GUARDED_BY(mutex_);  // The status of the last sign.
  std::optional<storage::TakenJob> at_hand_ ABSL_GUARDED_BY(mutex_);
  std::stop_source lost_ ABSL_GUARDED_BY(mutex_);  // The job at hand is another's.
  std::thread signs_;
};

}  // namespace isthmus::server
