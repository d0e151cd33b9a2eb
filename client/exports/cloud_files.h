// The merged map's points as files that are written while they come.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "client/exports/limits.h"
#include "client/library/client.h"
#include "core/earth/site.h"

namespace isthmus::exports {

struct CloudSummary {
  int64_t revision = 0;
  uint64_t points = 0;
  uint64_t files = 1;
};

// Receives the points so far.
using CloudProgress = std::function<void(uint64_t)>;

// LAS 1.4 into PATH or a stream, see LasWriter. With a site in its UTM zone, with the system's WKT
// and heights above the ellipsoid; else in the map's frame, and no system is named. Errors of
// QueryRegion and of files. Holds one piece of points at a time; where PATH is a stream all of them
// wait on the disk, as the head tells their bounds.
absl::StatusOr<CloudSummary> WriteLas(client::Client& client, const RegionQuery& query,
                                      const std::optional<earth::Site>& site,
                                      const std::string& path, const CloudProgress& progress);

// A map folder of Autoware: `folder`/pointcloud_map/X_Y.pcd, binary, of the points with X <= x < X
// + tile_m and Y <= y < Y + tile_m, and `folder`/pointcloud_map_metadata.yaml, as its map loader
// reads them. With a site whose axes are east and north also map_projector_info.yaml
// (LocalCartesian). A whole number of metres, at least 1, per tile (InvalidArgument). The folder
// appears once it is complete; AlreadyExists where there is one, NotFound where no point is to be
// written. Holds kTileBytesHeld of points and one tile.
absl::StatusOr<CloudSummary> WriteTiles(client::Client& client, const RegionQuery& query,
                                        const std::optional<earth::Site>& site, double tile_m,
                                        const std::string& folder, const CloudProgress& progress);

}  // namespace isthmus::exports
