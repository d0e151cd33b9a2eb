#include "client/cli/region_reader.h"

#include "client/console/console.h"

namespace isthmus::cli {

absl::StatusOr<RegionChunk> ReadRegion(client::Client& client, const RegionQuery& query) {
  RegionChunk all;
  Progress progress("points", 0);
  const absl::Status status = client.QueryRegion(query, [&](const RegionChunk& chunk) {
    all.revision = chunk.revision;
    all.robots = chunk.robots;
    all.resolution_m = chunk.resolution_m;
    all.points.insert(all.points.end(), chunk.points.begin(), chunk.points.end());
    progress.Update(all.points.size());
    return true;
  });
  if (!status.ok()) return status;
  return all;
}

}  // namespace isthmus::cli
