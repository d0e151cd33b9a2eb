// Workers of a site in PostgreSQL, each started again whenever it ends.
#pragma once

#include <sys/types.h>

#include <string>
#include <thread>
#include <vector>

#include "core/concurrency/mutex.h"

namespace isthmus::faults {

// Thread safe.
class WorkerGroup {
 public:
  // As many as `stores`; their logs go to `folder`.
  WorkerGroup(const std::string& program, const std::string& folder,
              const std::vector<std::string>& stores);
  ~WorkerGroup();  // Kills what still runs.
  WorkerGroup(const WorkerGroup&) = delete;
  WorkerGroup& operator=(const WorkerGroup&) = delete;

  void Kill(int worker);
  // Ends all politely. False, and the log of one in `why`, if one ended ill.
  bool Stop(std::string* why);

 private:
  void Supervise(int index, const std::string& store);
  void End(int signal);

  const std::string program_, folder_;
  Mutex mutex_;
  bool is_stopping_ ABSL_GUARDED_BY(mutex_) = false;
  std::vector<pid_t> pids_ ABSL_GUARDED_BY(mutex_);  // 0: none.
  std::string trouble_ ABSL_GUARDED_BY(mutex_);
  std::vector<std::thread> supervisors_;
};

}  // namespace isthmus::faults
