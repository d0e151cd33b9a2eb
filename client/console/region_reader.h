// The merged map's points in memory: what `query`, `picture` and `merge` need.
#pragma once

#include <absl/status/statusor.h>

#include "client/library/client.h"

namespace isthmus::cli {

// All chunks of the region as one. Shows progress.
absl::StatusOr<RegionChunk> ReadRegion(client::Client& client, const RegionQuery& query);

}  // namespace isthmus::cli
