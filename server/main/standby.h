// A server's time as a spare: it waits for its sites, says for whom, and ends at once when told to.
#pragma once

#include <atomic>
#include <string>
#include <thread>

#include "core/concurrency/mutex.h"
#include "server/main/service_manager.h"
#include "server/main/stop_signal.h"

namespace isthmus::server {

// From its making until the server serves. Thread safe.
class Standby {
 public:
  // `signal` must outlive it; nobody else waits for it meanwhile. SIGTERM and SIGINT end the
  // process with 0, whatever another thread waits for: nothing has been acknowledged yet.
  explicit Standby(StopSignal* signal);
  ~Standby();
  Standby(const Standby&) = delete;
  Standby& operator=(const Standby&) = delete;

  // Why it waits, as often as that is looked at; said once. The service manager learns that the
  // server is ready, as far as it can be.
  void Note(const std::string& why);

 private:
  void Attend();

  StopSignal* const signal_;
  const ServiceManager manager_;
  std::atomic<bool> is_over_ = false;
  Mutex mutex_;
  std::string why_ ABSL_GUARDED_BY(mutex_);
  std::thread thread_;
};

// For a server whose sites are another's by now: says why, and ends the process at once. Scans that
// were not stored were not acknowledged as durable, and robots hold it still.
[[noreturn]] void EndTakenOver(const std::string& why, int exit_code);

}  // namespace isthmus::server
