// The options by which commands name a part of the merged map.
#pragma once

#include <absl/status/statusor.h>

#include <limits>
#include <string>
#include <vector>

#include "client/console/command.h"

namespace isthmus::cli {

struct RegionOptions {
  std::string box, sphere, oriented_box, polygon, corridor, robot;
  std::vector<std::string> classes;
  double width_m = 0;  // The corridor's.
  double min_z = -std::numeric_limits<double>::infinity();
  double max_z = std::numeric_limits<double>::infinity();
  RegionQuery query;  // Map and resolution.
};

// --box, --sphere, --oriented-box, --polygon, --corridor, --width, --robot, --class, --min-z,
// --max-z, --map.
void AddRegionOptions(CLI::App& command, RegionOptions& options);
// The same without --robot and --class, for what is not asked of one robot's map.
void AddPlaceOptions(CLI::App& command, RegionOptions& options);

// --min-z and --max-z alone; `also` goes on with the help.
void AddHeightOptions(CLI::App& command, RegionOptions& options, const std::string& also = "");

// --map, which was --component: a session in the map, or its number.
CLI::Option* AddMapOption(CLI::App& command, MapName& map, const std::string& help = "");

// InvalidArgument, saying what an option should look like.
absl::StatusOr<RegionQuery> ParseRegion(const RegionOptions& options);

}  // namespace isthmus::cli
