// Servers of one map in PostgreSQL, each started again whenever it ends, as a supervisor would.
#pragma once

#include <sys/types.h>

#include <atomic>
#include <map>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "core/concurrency/mutex.h"

namespace isthmus::faults {

// Thread safe.
class ServerGroup {
 public:
  // A server for each URL of the store. All but their store's data is in `folder`.
  ServerGroup(const std::string& program, const std::string& folder,
              const std::vector<std::string>& stores, double lease_s);
  ~ServerGroup();  // Kills what still runs.
  ServerGroup(const ServerGroup&) = delete;
  ServerGroup& operator=(const ServerGroup&) = delete;

  // The addresses of all servers, for a client.
  std::string addresses() const;
  // One that began to serve, and when, in seconds of NowS().
  struct Owner {
    int server = -1;
    double since_s = 0;
    bool has_ended = false;
  };
  // All so far, in order.
  std::vector<Owner> owners() const;
  // Waits for the first.
  void AwaitOwner() const;
  // The newest, though it may be paused; -1 where it has ended.
  int OwnerNow() const;
  // Without effect on one that is just being started.
  void Signal(int server, int signal);
  // The exit codes of servers that ended of their own accord, and how often each came.
  std::map<int, int> ends() const;
  // Ends all politely. False, and the log of one in `why`, if one ended ill.
  bool Stop(std::string* why);

 private:
  struct Server {
    std::string folder, store;
    pid_t pid = 0;  // 0: none.
    std::thread supervisor = {};
  };

  void Supervise(int index);
  void End(int signal);

  const std::string program_;
  const double lease_s_;
  std::vector<std::unique_ptr<Server>> servers_;  // Their pids are guarded by mutex_.
  mutable Mutex mutex_;
  mutable CondVar changed_;
  bool is_stopping_ ABSL_GUARDED_BY(mutex_) = false;
  std::vector<Owner> owners_ ABSL_GUARDED_BY(mutex_);
  std::map<int, int> ends_ ABSL_GUARDED_BY(mutex_);
  std::string trouble_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace isthmus::faults
