#include "client/cli/region_options.h"

#include <absl/strings/numbers.h>
#include <absl/strings/str_cat.h>
#include <absl/strings/str_split.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace isthmus::cli {
namespace {

// What stands for "no limit" in a box, metres: maps end long before it.
constexpr double kNoLimitM = 1e7;

// "1,2,3" as three numbers.
absl::StatusOr<std::vector<double>> Numbers(const std::string& text, size_t count,
                                            const char* option, const char* form) {
  std::vector<double> numbers;
  for (absl::string_view part : absl::StrSplit(text, ',')) {
    double value = 0;
    if (!absl::SimpleAtod(part, &value)) break;
    numbers.push_back(value);
  }
  if (numbers.size() == count &&
      std::count(text.begin(), text.end(), ',') == static_cast<long>(count) - 1) {
    return numbers;
  }
  return absl::InvalidArgumentError(absl::StrCat(option, " is ", form, ", not '", text, "'"));
}

absl::Status TakeBand(const RegionOptions& options, RegionQuery& query) {
  if (std::isinf(options.min_z) && std::isinf(options.max_z)) return absl::OkStatus();
  if (!(options.min_z <= options.max_z)) {
    return absl::InvalidArgumentError(absl::StrCat("--min-z ", options.min_z, " is above --max-z ",
                                                   options.max_z, ": exchange them"));
  }
  Box box = query.box.value_or(
      Box{Eigen::Vector3d::Constant(-kNoLimitM), Eigen::Vector3d::Constant(kNoLimitM)});
  box.min.z() = std::max(box.min.z(), options.min_z);
  box.max.z() = std::min(box.max.z(), options.max_z);
  if (box.min.z() > box.max.z()) {
    return absl::InvalidArgumentError("--box has nothing between --min-z and --max-z");
  }
  query.box = box;
  return absl::OkStatus();
}

}  // namespace

void AddRegionOptions(CLI::App& command, RegionOptions& options) {
  CLI::Option* box = command.add_option("--box", options.box, "x0,y0,z0,x1,y1,z1 in the map frame");
  CLI::Option* sphere =
      command.add_option("--sphere", options.sphere, "x,y,z,radius in the map frame");
  sphere->excludes(box);
  command.add_option("--min-z", options.min_z, "Nothing below, metres in the map")
      ->excludes(sphere);
  command.add_option("--max-z", options.max_z, "Nothing above")->excludes(sphere);
  command.add_option("--robot", options.robot, "What this robot saw alone");
  command.add_option("--component", options.query.component, "0 is the largest")
      ->capture_default_str();
}

absl::StatusOr<RegionQuery> ParseRegion(const RegionOptions& options) {
  RegionQuery query = options.query;
  if (!options.box.empty()) {
    const auto n = Numbers(options.box, 6, "--box", "x0,y0,z0,x1,y1,z1");
    if (!n.ok()) return n.status();
    const double* v = n->data();
    query.box = Box{{v[0], v[1], v[2]}, {v[3], v[4], v[5]}};
  }
  if (!options.sphere.empty()) {
    const auto n = Numbers(options.sphere, 4, "--sphere", "x,y,z,radius");
    if (!n.ok()) return n.status();
    query.sphere = {{(*n)[0], (*n)[1], (*n)[2]}, (*n)[3]};
  }
  query.robot = RobotId(options.robot);
  if (absl::Status status = TakeBand(options, query); !status.ok()) return status;
  return query;
}

}  // namespace isthmus::cli
