// The merged map as grid maps, floor by floor.
#pragma once

#include <absl/status/statusor.h>

#include <optional>
#include <string>
#include <vector>

#include "client/library/client.h"
#include "core/floors/grid_map.h"

namespace isthmus::cli {

struct GridRequest {
  RegionQuery query;                       // Its resolution is the cells'.
  std::optional<floors::HeightBand> band;  // In the map frame; absent: around each floor.
  std::string name;                        // Without an extension.
};

struct GridFile {
  std::string name;  // The YAML file's.
  int64_t width = 0, height = 0, occupied = 0, free = 0;
  std::optional<int64_t> rooms = {},
                         doors = {};   // Absent where the map is too large to look for them.
  double lowest_m = 0, highest_m = 0;  // Sensors on this floor; with a band, that.
};

// Writes NAME_floorK.pgm and .yaml, and NAME_floorK_rooms.geojson beside them, K from 0 upwards, or
// NAME.pgm and so on of a band.
// Floors without anything of the map in the box get none; NotFound where all are so, or the band.
// FailedPrecondition where no robot was in the component.
absl::StatusOr<std::vector<GridFile>> WriteGrids(client::Client& client,
                                                 const GridRequest& request);

}  // namespace isthmus::cli
