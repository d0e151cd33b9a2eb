// A site of a PostgreSQL database that another server has, opened for reading only.
#pragma once

#include <absl/status/statusor.h>

#include <memory>
#include <string>

#include "storage/map_follower.h"
#include "storage/map_store.h"

namespace isthmus::storage {

struct PostgresReplica {
  std::unique_ptr<MapStore> store;        // Refuses every change: FailedPrecondition.
  std::unique_ptr<MapFollower> follower;  // By a connection of its own.
};

// Takes no lock and no lease, with any owner of the site, and changes nothing: its connections can
// only read, so a role will do that may no more, and a PostgreSQL that follows another one. Errors
// as CheckSite and CheckMigrated say, and Unavailable where PostgreSQL cannot be reached.
absl::StatusOr<PostgresReplica> OpenPostgresReplica(const std::string& url,
                                                    const std::string& site);

}  // namespace isthmus::storage
