// The work that a site's server hands out to workers: jobs on a board that all of them reach.
#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include <cstdint>
#include <set>
#include <string>
#include <vector>

namespace isthmus::storage {

// A job is a key, of which the board has one at a time, and a payload: all that its result follows
// from beside records that never change, so that whoever does it, and however often, it comes out
// the same. Both are the poster's affair.
struct PostedJob {
  std::string key = {};
  std::string payload = {};
  bool is_urgent = false;  // To be done before those that are not.
};

// A job on the board, however far it is.
struct BoardJob {
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

// Processes that gave a sign of life lately: those that do this program's jobs, and those of
// another version, which leave them alone.
struct WorkerCount {
  int64_t able = 0, of_other_versions = 0;

  friend bool operator==(const WorkerCount&, const WorkerCount&) = default;
};

// The server's side. What is on it may be lost with the database's last moments and is no record of
// anything: it can be posted again. Thread safe. Errors as MapStore's.
class JobBoard {
 public:
  virtual ~JobBoard() = default;

  // Changes nothing.
  virtual absl::StatusOr<WorkerCount> CountWorkers() = 0;
  // In place of one of the same key, whose worker is not listened to any more. FailedPrecondition,
  // with the reason, where one of that key was set aside.
  virtual absl::Status Post(const PostedJob& job) = 0;
  // In order of posting.
  virtual absl::StatusOr<std::vector<BoardJob>> ListAll() = 0;
  // Of all that workers may still take or have ended, those set aside too.
  virtual absl::StatusOr<std::set<std::string>> ListKeys() = 0;
  // In order of posting. Those that are set aside are listed once.
  virtual absl::StatusOr<std::vector<EndedJob>> ListEnded() = 0;
  // Takes ended ones off the board; those set aside stay as a warning.
  virtual absl::Status Remove(const std::vector<EndedJob>& jobs) = 0;
  // Takes the job of that key off the board, however far it is: nobody wants it any more.
  virtual absl::Status Drop(const std::string& key) = 0;
  // The same if no worker has begun with it; whether none had.
  virtual absl::StatusOr<bool> TakeBack(const std::string& key) = 0;
  // Takes all off that have not ended. What several workers have ended with is set aside instead:
  // it is not for the server to try.
  virtual absl::Status Withdraw() = 0;
};

}  // namespace isthmus::storage
