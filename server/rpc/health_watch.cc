#include "server/rpc/health_watch.h"

#include <absl/strings/str_cat.h>

#include <set>
#include <utility>

#include "core/concurrency/thread_role.h"
#include "isthmus/v1/access_service.grpc.pb.h"
#include "isthmus/v1/admin_service.grpc.pb.h"
#include "isthmus/v1/edit_service.grpc.pb.h"
#include "isthmus/v1/event_service.grpc.pb.h"
#include "isthmus/v1/localisation_service.grpc.pb.h"
#include "isthmus/v1/map_service.grpc.pb.h"
#include "isthmus/v1/session_service.grpc.pb.h"

namespace isthmus::rpc {
namespace {

// With less left on the disk robots had better go elsewhere: a minute or so of a few robots, while
// somebody makes room. Half of what the map file leaves, so that the map gives way first.
constexpr uint64_t kDiskNearlyFull_bytes = uint64_t{128} << 20;

const std::vector<std::string>& AllServices() {
  static const auto* const services = new std::vector<std::string>{
      v1::SessionService::service_full_name(),      v1::MapService::service_full_name(),
      v1::EditService::service_full_name(),         v1::AdminService::service_full_name(),
      v1::LocalisationService::service_full_name(), v1::AccessService::service_full_name(),
      v1::EventService::service_full_name(),
  };
  return *services;
}

std::string WhyNoneCanBeStored(const ServerLoad& load) {
  if (!load.storage_problem.empty()) return load.storage_problem;
  if (load.disk.total_bytes == 0 || load.disk.free_bytes >= kDiskNearlyFull_bytes) return {};
  return absl::StrCat("the disk is nearly full: ", load.disk.free_bytes >> 20,
                      " MiB are left; free some space on it, or delete sessions");
}

}  // namespace

std::vector<DegradedService> FindDegraded(const ServerLoad& load) {
  std::vector<DegradedService> degraded;
  if (load.replica) {
    constexpr char kWhy[] = "this server is a replica, which only reads the map";
    degraded.push_back({v1::EditService::service_full_name(), kWhy});
    degraded.push_back({v1::SessionService::service_full_name(), kWhy});
  }
  if (!load.storage_problem.empty()) {
    degraded.push_back({v1::EditService::service_full_name(), load.storage_problem});
  }
  if (load.map_is_loading) {
    degraded.push_back({v1::MapService::service_full_name(),
                        "the map is being composed after the start; it serves in a moment"});
  }
  if (const std::string why = WhyNoneCanBeStored(load); !why.empty()) {
    degraded.push_back({v1::SessionService::service_full_name(), why});
  }
  return degraded;
}

HealthWatch::HealthWatch(std::vector<Site*> sites, std::chrono::milliseconds interval,
                         OnHealth on_health)
    : sites_(std::move(sites)), interval_(interval), on_health_(std::move(on_health)) {
  Review();
  thread_ = std::thread([this] { Run(); });
}

HealthWatch::~HealthWatch() {
  {
    MutexLock lock(&mutex_);
    stopped_ = true;
    stop_.SignalAll();
  }
  thread_.join();
}

void HealthWatch::Review() {
  std::set<std::string> degraded;
  for (Site* site : sites_) {
    for (const DegradedService& one : FindDegraded(site->pipeline.GetLoad())) {
      degraded.insert(one.service);
    }
  }
  for (const std::string& service : AllServices()) {
    const bool serves = !degraded.contains(service);
    const auto [told, is_new] = told_.try_emplace(service, serves);
    if (!is_new && std::exchange(told->second, serves) == serves) continue;
    on_health_(service, serves);
  }
}

void HealthWatch::Run() {
  NameThread("health");
  MutexLock lock(&mutex_);
  while (!stopped_) {
    stop_.WaitFor(&mutex_, interval_);
    if (stopped_) return;
    mutex_.Unlock();
    try {
      Review();
    } catch (...) {
      // Without memory for it all stays as it was told, until the next look.
    }
    mutex_.Lock();
  }
}

}  // namespace isthmus::rpc
