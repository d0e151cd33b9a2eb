// A site in PostgreSQL as a worker has it: it reads the map, takes jobs, and leaves their results.
#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "core/concurrency/mutex.h"
#include "fleet/postgresql/postgresql.h"
#include "storage/map_store.h"

namespace isthmus::storage {

// A site that some server has opened before; whether one has it now is no matter. The only change
// that it makes is PutFeatures, which keeps data that follow from the submaps anyway; the rest is
// FailedPrecondition, as that is for the site's owner. NotFound where there is no such site,
// FailedPrecondition where its schema is of another version; the errors of S3Bucket where its
// bucket cannot be read.
absl::StatusOr<std::unique_ptr<MapStore>> OpenWorkerStore(const std::string& url,
                                                          const std::string& site);

struct TakenJob {
  int64_t id = 0, attempt = 0;
  std::string key, payload;
  int64_t connection = 0;  // PostgresConnection::generation().
};

// The worker's side of a JobQueue. Thread safe. Errors are those of the connection; it finds a new
// way by itself.
class JobTaker {
 public:
  // `worker` is a name that no other process has. Takes jobs of the same version only. NotFound
  // where no server has made the tables of jobs yet.
  static absl::StatusOr<std::unique_ptr<JobTaker>> Open(const std::string& url,
                                                        const std::string& site,
                                                        const std::string& worker);
  ~JobTaker();  // Says goodbye.

  // The next that nobody has, or whose worker is overdue. It is this worker's until kJobLease after
  // the last KeepAlive. One that too many workers ended with is set aside.
  absl::StatusOr<std::optional<TakenJob>> Take();
  // Says that this worker lives, and keeps the job, where there is one. False: it is another's by
  // now, or withdrawn; its result would not be taken. PermissionDenied where its role lacks rights
  // that jobs need: then it is no worker to whom the server would give any.
  absl::StatusOr<bool> KeepAlive(const std::optional<TakenJob>& job);
  // False where the job is not this worker's any more: then nothing is left.
  absl::StatusOr<bool> Finish(const TakenJob& job, const std::string& result);
  absl::StatusOr<bool> Fail(const TakenJob& job, const std::string& problem);
  // To be taken by another one, as if it had never been taken.
  absl::StatusOr<bool> GiveBack(const TakenJob& job);

 private:
  JobTaker(std::unique_ptr<PostgresConnection> connection, std::string schema, std::string worker);

  // A change of a job that is this worker's; behind its own parameters come id and attempt.
  Statement OfMine(const std::string& change) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  Mutex mutex_;
  const std::unique_ptr<PostgresConnection> connection_ ABSL_PT_GUARDED_BY(mutex_);
  const std::string schema_, worker_;
};

}  // namespace isthmus::storage
