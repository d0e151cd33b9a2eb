// The refusal of maps in databases by a server that is built without fleet/.
#include "server/main/database_maps.h"

namespace isthmus::server {
namespace {

absl::Status NotBuilt() {
  return absl::InvalidArgumentError(
      "this isthmus-server was built without maps in databases (-DISTHMUS_FLEET=OFF): leave out "
      "--store, storage.store and storage.bucket, or take one that has them");
}

}  // namespace

absl::Status CheckDatabase(const ServerConfig& config) {
  return config.store.empty() && config.bucket.empty() ? absl::OkStatus() : NotBuilt();
}

absl::StatusOr<std::unique_ptr<storage::MapStore>> OpenDatabaseMap(
    const ServerConfig&, const std::string&, const SiteEvents&,
    const std::function<void(const std::string&)>&) {
  return NotBuilt();
}

absl::StatusOr<FollowedMap> OpenFollowedMap(const ServerConfig&, const std::string&) {
  return NotBuilt();
}

}  // namespace isthmus::server
