// Maps of sites in a database, which several servers reach. The build decides whether a server has
// them: fleet/server has what opens them, no_database_maps.cc what refuses them.
#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include <functional>
#include <memory>
#include <string>

#include "server/main/config.h"
#include "storage/map_follower.h"
#include "storage/map_store.h"

namespace isthmus::server {

// Callbacks about a site in a database, for a server with spares; see storage::LeaseOptions.
struct SiteEvents {
  std::function<void(const std::string& why)> on_wait = nullptr;
  std::function<void(const std::string& why)> on_lost = nullptr;
};

// InvalidArgument, with the reason, where this server can take no database or bucket of these
// names.
absl::Status CheckDatabase(const ServerConfig& config);

// The map of a site, which is this server's from now on. `on_problem` is told what a person should
// know. Errors as OpenPostgresStore.
absl::StatusOr<std::unique_ptr<storage::MapStore>> OpenDatabaseMap(
    const ServerConfig& config, const std::string& site, const SiteEvents& events,
    const std::function<void(const std::string& problem)>& on_problem);

struct FollowedMap {
  std::unique_ptr<storage::MapStore> store;        // Refuses every change: FailedPrecondition.
  std::unique_ptr<storage::MapFollower> follower;  // By a connection of its own.
};
// The map of a site that another server has, to be read only. Errors as OpenPostgresReplica.
absl::StatusOr<FollowedMap> OpenFollowedMap(const ServerConfig& config, const std::string& site);

}  // namespace isthmus::server
