// The store in PostgreSQL: a schema of a database for each site.
#pragma once

#include <absl/status/statusor.h>

#include <cstddef>
#include <functional>
#include <memory>
#include <string>

#include "fleet/postgresql/site_lease.h"
#include "storage/map_store.h"
#include "storage/objects/limits.h"

namespace isthmus::storage {

struct PostgresOptions {
  // Wait for the disk on every commit (synchronous_commit). Off: a power cut, or a crash of
  // PostgreSQL, may lose the last commits, never the integrity of the rest.
  bool sync_every_commit = true;
  // Step to which submap coordinates are rounded, metres.
  double resolution_m = 0.001;
  // Told what a person should know, on opening and later.
  std::function<void(const std::string& problem)> on_problem = nullptr;
  // The URL of a bucket (s3_bucket.h) for large values; empty: the site's own, or none.
  std::string bucket = {};
  size_t smallest_object = kSmallestObject;  // As LargeValues has it.
  LeaseOptions lease = {};                   // `on_problem` is this one's.
};

// The schema that a site's tables are in: isthmus_NAME, and isthmus for the default site, which may
// be left empty.
std::string SchemaOfSite(const std::string& site);

// InvalidArgument, with the reason, where PostgreSQL or a server would not take the site's name.
absl::Status CheckSite(const std::string& site);

// Opens, or creates, the site's schema and migrates it to the newest version. `url` is a PostgreSQL
// connection URL without a password, see postgresql.h. Errors as CheckSite, SiteLease::Take and
// OpenOwnersBucket say, and Unavailable where the server cannot be reached.
//
// While the server is away all is Unavailable; it goes on by itself once it is back. A Write whose
// commit was under way when the connection was lost waits until the server tells what became of it.
absl::StatusOr<std::unique_ptr<MapStore>> OpenPostgresStore(const std::string& url,
                                                            const std::string& site,
                                                            const PostgresOptions& options = {});

}  // namespace isthmus::storage
