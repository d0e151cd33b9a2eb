#include "core/floors/grid_map.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/floors/ground.h"
#include "core/floors/limits.h"
#include "core/formats/octomap_reader.h"

namespace isthmus::floors {
namespace {

constexpr char kPixels[] = {static_cast<char>(205), static_cast<char>(254), 0};  // By GridCell.

using Cubes = std::vector<VoxelCube>;

// Makes room for all cubes that may matter.
absl::Status Frame(const Cubes& cubes, GridMap* map) {
  constexpr int64_t kFar = std::numeric_limits<int32_t>::max();
  int64_t x0 = kFar, y0 = kFar, x1 = -kFar, y1 = -kFar;
  for (const VoxelCube& cube : cubes) {
    x0 = std::min<int64_t>(x0, cube.x);
    y0 = std::min<int64_t>(y0, cube.y);
    x1 = std::max<int64_t>(x1, cube.x + cube.edge);
    y1 = std::max<int64_t>(y1, cube.y + cube.edge);
  }
  map->width = x1 - x0;
  map->height = y1 - y0;
  map->origin = {static_cast<double>(x0) * map->resolution_m,
                 static_cast<double>(y0) * map->resolution_m};
  if (map->width * map->height > kMostCells) {
    return absl::ResourceExhaustedError(
        absl::StrCat("the grid map would have ", map->width, " by ", map->height,
                     " cells: give a coarser --resolution, or a --box"));
  }
  map->cells.assign(static_cast<size_t>(map->width * map->height), GridCell::kUnknown);
  return absl::OkStatus();
}

// True if the middle of one of the cube's voxels lies in the band.
bool Meets(const VoxelCube& cube, double resolution_m, const HeightBand& band) {
  const double first = (std::ceil(band.lowest_m / resolution_m - 0.5));
  const double last = (std::floor(band.highest_m / resolution_m - 0.5));
  return first <= last && cube.z <= last && cube.z + cube.edge - 1 >= first;
}

template <typename BandAt>
void Draw(const VoxelCube& cube, const BandAt& band_at, GridMap* map) {
  const auto x0 = static_cast<int64_t>(std::llround(map->origin.x() / map->resolution_m));
  const auto y0 = static_cast<int64_t>(std::llround(map->origin.y() / map->resolution_m));
  for (int64_t y = cube.y - y0; y < cube.y - y0 + cube.edge; ++y) {
    for (int64_t x = cube.x - x0; x < cube.x - x0 + cube.edge; ++x) {
      GridCell& cell = map->cells[static_cast<size_t>(y * map->width + x)];
      const GridCell drawn = cube.is_occupied ? GridCell::kOccupied : GridCell::kFree;
      if (cell >= drawn || !Meets(cube, map->resolution_m, band_at(x, y))) continue;
      cell = drawn;
    }
  }
}

}  // namespace

absl::Status NothingThere() {
  return absl::NotFoundError(
      "the box or height band holds nothing of the map: give another, or none");
}

HeightBand HeightsAround(const Floor& floor) {
  return {floor.lowest_m - kDeepestGroundM - kFloorBinM, floor.highest_m + kAboveSensorM};
}

absl::StatusOr<GridMap> GridOf(const std::string& octomap, const Floor& floor,
                               const std::optional<HeightBand>& fixed) {
  FreeSpace space;
  const auto resolution_m = formats::ParseOctomapBinary(
      octomap, [&space](const VoxelCube& cube) { space.cubes.push_back(cube); });
  if (!resolution_m.ok()) return resolution_m.status();
  space.resolution_m = *resolution_m;
  return GridOf(std::move(space), floor, fixed);
}

absl::StatusOr<GridMap> GridOf(FreeSpace space, const Floor& floor,
                               const std::optional<HeightBand>& fixed) {
  const double resolution_m = space.resolution_m;
  Cubes& cubes = space.cubes;
  const HeightBand all = fixed.value_or(HeightsAround(floor));
  std::erase_if(cubes, [&](const auto& cube) { return !Meets(cube, resolution_m, all); });
  if (cubes.empty()) return NothingThere();
  GridMap map;
  map.resolution_m = resolution_m;
  if (absl::Status status = Frame(cubes, &map); !status.ok()) return status;
  if (fixed) {
    for (const auto& cube : cubes)
      Draw(
          cube, [&](int64_t, int64_t) { return *fixed; }, &map);
    return map;
  }
  const double sensor_m = SensorHeight(cubes, resolution_m, floor.stations);
  const HeightField stations(map.origin, map.resolution_m, map.width, map.height, floor.stations);
  const auto band_at = [&](int64_t x, int64_t y) {
    const double station_m = stations.At(x, y);
    return HeightBand{station_m - sensor_m + kLowestObstacleM + resolution_m,
                      station_m + kAboveSensorM};
  };
  for (const auto& cube : cubes) Draw(cube, band_at, &map);
  return map;
}

std::string FormatPgm(const GridMap& map) {
  std::string pgm = absl::StrFormat("P5\n# %.9g m per cell\n%d %d\n255\n", map.resolution_m,
                                    map.width, map.height);
  pgm.reserve(pgm.size() + map.cells.size());
  for (int64_t y = map.height; y-- > 0;) {
    for (int64_t x = 0; x < map.width; ++x) pgm.push_back(kPixels[static_cast<int>(map.At(x, y))]);
  }
  return pgm;
}

std::string FormatMapYaml(const GridMap& map, const std::string& image) {
  return absl::StrFormat(
      "image: \"%s\"\nmode: trinary\nresolution: %.9g\norigin: [%.9g, %.9g, 0]\nnegate: 0\n"
      "occupied_thresh: 0.65\nfree_thresh: 0.196\n",
      image, map.resolution_m, map.origin.x(), map.origin.y());
}

}  // namespace isthmus::floors
