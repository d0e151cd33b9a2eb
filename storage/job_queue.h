// The work that a site's server hands out to workers: jobs in a queue that all of them reach.
#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include <cstdint>
#include <set>
#include <string>
#include <vector>

namespace isthmus::storage {

// A job is a key, of which the queue has one at a time, and a payload: all input of its result
// beside records that never change, so that the result comes out the same from any worker, at any
// time. Both are the poster's affair.
struct PostedJob {
  std::string key = {};
  std::string payload = {};
  bool is_urgent = false;  // To be done before those that are not.
};

// A job in the queue, however far it is.
struct QueuedJob {
  std::string key = {};
  std::string payload = {};
  bool is_open = false;       // It has not ended.
  bool is_set_aside = false;  // As of EndedJob.
};

struct EndedJob {
  int64_t id = 0;
  std::string key;
  std::string result;
  std::string problem;        // Why there is no result; empty: there is.
  bool is_set_aside = false;  // Worker after worker ended while it was at it.
};

// Processes that gave a sign of life lately: workers that do this program's jobs, and workers of
// another version, which leave them alone.
struct WorkerCount {
  int64_t able = 0, of_other_versions = 0;

  friend bool operator==(const WorkerCount&, const WorkerCount&) = default;
};

// The server's side. Jobs on it may be lost with the database's last moments and are no record of
// anything: they can be posted again. Thread safe. Errors as MapStore's.
class JobQueue {
 public:
  virtual ~JobQueue() = default;

  // Changes nothing.
  virtual absl::StatusOr<WorkerCount> CountWorkers() = 0;
  // In place of one of the same key, whose worker is not listened to any more. FailedPrecondition,
  // with the reason, where one of that key was set aside.
  virtual absl::Status Post(const PostedJob& job) = 0;
  // In order of posting.
  virtual absl::StatusOr<std::vector<QueuedJob>> ListAll() = 0;
  // Keys of all jobs that workers may still take or have ended, and of jobs set aside.
  virtual absl::StatusOr<std::set<std::string>> ListKeys() = 0;
  // In order of posting. Jobs that are set aside are listed once.
  virtual absl::StatusOr<std::vector<EndedJob>> ListEnded() = 0;
  // Takes ended ones off the queue; jobs set aside stay as a warning.
  virtual absl::Status Remove(const std::vector<EndedJob>& jobs) = 0;
  // Takes the job of that key off the queue, however far it is: nobody wants it any more.
  virtual absl::Status Drop(const std::string& key) = 0;
  // The same if no worker has begun with it; true if none had.
  virtual absl::StatusOr<bool> TakeBack(const std::string& key) = 0;
  // Takes all jobs off that have not ended. A job that several workers have ended with is set aside
  // instead: it is not for the server to try.
  virtual absl::Status Withdraw() = 0;
};

}  // namespace isthmus::storage
