// The health of each service, kept up to date for clients of grpc.health.v1.
#pragma once

#include <chrono>
#include <functional>
#include <map>
#include <string>
#include <thread>
#include <vector>

#include "core/concurrency/mutex.h"
#include "core/records/server_status.h"
#include "server/rpc/site.h"

namespace isthmus::rpc {

// Services that cannot do their part for a site with such a load, in the order of their names;
// empty if all is well.
//   SessionService  nothing can be stored, or the disk has less than kDiskNearlyFull_bytes left
//   EditService     nothing can be stored
//   MapService      the map is being composed after the start
std::vector<DegradedService> FindDegraded(const ServerLoad& load);

// Looks at every site again and again. A service is one for all sites: one in trouble is enough.
class HealthWatch {
 public:
  // Told if a service, named in full ("isthmus.v1.MapService"), serves; from one thread at a time.
  using OnHealth = std::function<void(const std::string& service, bool is_serving)>;

  // Tells of every service before it returns, then whatever changes. The sites must outlive it.
  HealthWatch(std::vector<Site*> sites, std::chrono::milliseconds interval, OnHealth on_health);
  ~HealthWatch();  // Tells nothing after this.

 private:
  void Review();
  void Run();

  const std::vector<Site*> sites_;
  const std::chrono::milliseconds interval_;
  const OnHealth on_health_;
  std::map<std::string, bool> told_;  // Touched by one thread at a time.
  Mutex mutex_;
  CondVar stop_;
  bool stopped_ ABSL_GUARDED_BY(mutex_) = false;
  std::thread thread_;
};

}  // namespace isthmus::rpc
