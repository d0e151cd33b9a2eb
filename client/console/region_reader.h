// The merged map as commands read it: its points in memory, and which map it is.
#pragma once

#include <absl/status/statusor.h>

#include "client/library/client.h"

namespace isthmus::cli {

// All chunks of the region as one. Shows progress.
absl::StatusOr<RegionChunk> ReadRegion(client::Client& client, const RegionQuery& query);

// Says on stderr whose map a number means, where the server has more than one.
void SayWhichMap(client::Client& client, const MapName& map);

}  // namespace isthmus::cli
