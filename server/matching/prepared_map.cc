#include "server/matching/prepared_map.h"

#include "server/matching/refinable_map.h"

namespace isthmus::matching {
namespace {

constexpr double kIndoorVoxelM = 0.25, kOutdoorVoxelM = 0.5;

// Outdoors half as fine is enough, and a quarter of the cost; which it is shows at the coarse one.
RefinableMap MakeRefinable(const SessionMap& map, RefineOptions* options) {
  options->voxel_m = kOutdoorVoxelM;
  RefinableMap coarse(map, *options);
  if (IsOutdoors(coarse.data().points, SensorPositions(map))) return coarse;
  options->voxel_m = kIndoorVoxelM;
  return RefinableMap(map, *options);
}

}  // namespace

PreparedMap::PreparedMap(const SessionMap& map)
    : map_(map),
      refinable_(MakeRefinable(map, &refine_options_)),
      walls_(map, refinable_.data().points),
      free_space_(map, refinable_.data().points, walls_.T_level_odom(), FreeSpaceOptions()),
      prepare_ms_(watch_.Ms()) {}

}  // namespace isthmus::matching
