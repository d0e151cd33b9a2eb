// The maps of a server, opened: the map in the data folder, and the maps of further sites.
#pragma once

#include <absl/status/statusor.h>

#include <memory>
#include <string>
#include <vector>

#include "core/io/directory_lock.h"
#include "server/main/config.h"
#include "server/main/database_maps.h"
#include "server/pipeline.h"

namespace isthmus::server {

struct OpenMap {
  std::string name;    // The site's.
  std::string folder;  // Holds all that is of this site and not in a database elsewhere.
  // The lock of the folder, where the store is elsewhere and takes none itself.
  std::unique_ptr<io::DirectoryLock> lock;
  std::unique_ptr<Pipeline> pipeline;
};

// The default site, in `folder`, first; then the others, in folder/sites/NAME, made where missing.
// Memory for points and threads for odometry are shared out among them evenly, a thread each at
// least. Errors are those of stores and pipelines, with the site's name. A site that another server
// has is waited for where the configuration says so: one after the other, all servers in this
// order.
absl::StatusOr<std::vector<OpenMap>> OpenMaps(const std::string& folder, const ServerConfig& config,
                                              const SiteEvents& events = {});

}  // namespace isthmus::server
