// Grid maps of ROS's map servers, of what rays found free and occupied near a floor.
#pragma once

#include <absl/status/statusor.h>

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/floors/floors.h"
#include "core/map/free_space.h"

namespace isthmus::floors {

enum class GridCell : uint8_t { kUnknown, kFree, kOccupied };

struct GridMap {
  double resolution_m = 0;                           // Edge of a cell.
  Eigen::Vector2d origin = Eigen::Vector2d::Zero();  // Lower left corner, map frame.
  int64_t width = 0, height = 0;                     // Cells along x and y.
  std::vector<GridCell> cells;                       // Row by row, the lowest y first.

  GridCell At(int64_t x, int64_t y) const { return cells[static_cast<size_t>(y * width + x)]; }
};

// The heights that count as in a robot's way.
struct HeightBand {
  double lowest_m = 0, highest_m = 0;
};

// The heights that GridOf needs for a floor: the stations', with what is looked for
// below and above them.
HeightBand HeightsAround(const Floor& floor);

// NotFound, as GridOf says it, where there is nothing to draw.
absl::Status NothingThere();

// A cell is occupied if a voxel over it, with its middle in the band, is; else free if one is; else
// unknown. The band is `fixed`, in the map, or lies over the ground: the
// nearest station's height less that of the sensor, which is the median over all stations under
// which ground was found; from kLowestObstacleM and a voxel above the ground to kAboveSensorM above
// the sensor. ResourceExhausted beyond kMostCells. NotFound without any voxel in the band: no map
// server takes a map of no cells.
absl::StatusOr<GridMap> GridOf(FreeSpace space, const Floor& floor,
                               const std::optional<HeightBand>& fixed);
// The same of a .bt file; InvalidArgument for bytes that are none.
absl::StatusOr<GridMap> GridOf(const std::string& octomap, const Floor& floor,
                               const std::optional<HeightBand>& fixed);

// As map_server and nav2_map_server read them, mode trinary: 0 occupied, 254 free, 205 unknown, the
// highest y first, with thresholds that keep 205 apart from both (205 is a probability of 0.196).
std::string FormatPgm(const GridMap& map);
// `image` is the name of the PGM beside it.
std::string FormatMapYaml(const GridMap& map, const std::string& image);

}  // namespace isthmus::floors
