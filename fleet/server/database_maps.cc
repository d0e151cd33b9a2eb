// Maps in databases as a server opens them: in PostgreSQL.
#include "server/main/database_maps.h"

#include <absl/strings/str_cat.h>

#include <chrono>
#include <cstdint>
#include <utility>

#include "fleet/objects/s3_bucket.h"
#include "fleet/postgresql/postgres_replica.h"
#include "fleet/postgresql/postgres_store.h"
#include "fleet/postgresql/postgresql.h"

namespace isthmus::server {
namespace {

absl::Status Named(const ServerConfig& config, const char* setting, const absl::Status& status) {
  return AtPlace(config, setting,
                 absl::Status(status.code(), absl::StrCat(setting, ": ", status.message())));
}

}  // namespace

absl::Status CheckDatabase(const ServerConfig& config) {
  absl::Status status;
  if (!config.store.empty()) {
    status = Named(config, "storage.store", storage::CheckPostgresUrl(config.store));
  }
  if (status.ok() && !config.bucket.empty()) {
    status = Named(config, "storage.bucket", storage::CheckBucketUrl(config.bucket));
  }
  return status;
}

absl::StatusOr<std::unique_ptr<storage::MapStore>> OpenDatabaseMap(
    const ServerConfig& config, const std::string& site, const SiteEvents& events,
    const std::function<void(const std::string& problem)>& on_problem) {
  storage::LeaseOptions lease;
  lease.length = std::chrono::milliseconds(static_cast<int64_t>(1000 * config.lease_s));
  lease.on_lost = events.on_lost;
  if (config.standby) {
    lease.on_wait = [note = events.on_wait](const std::string& why) {
      if (note) note(why);
      return true;
    };
  }
  return storage::OpenPostgresStore(config.store, site,
                                    {.sync_every_commit = config.storage.sync_every_commit,
                                     .resolution_m = config.storage.resolution_m,
                                     .on_problem = on_problem,
                                     .bucket = config.bucket,
                                     .lease = lease});
}

absl::StatusOr<FollowedMap> OpenFollowedMap(const ServerConfig& config, const std::string& site) {
  auto replica = storage::OpenPostgresReplica(config.store, site);
  if (!replica.ok()) return replica.status();
  return FollowedMap{std::move(replica->store), std::move(replica->follower)};
}

}  // namespace isthmus::server
