#include "client/cli/region_options.h"

#include <absl/strings/numbers.h>
#include <absl/strings/str_cat.h>
#include <absl/strings/str_split.h>

#include <algorithm>
#include <cmath>
#include <variant>
#include <vector>

#include "api/convert/region_place.h"
#include "client/console/numbers.h"
#include "core/geometry/angles.h"

namespace isthmus::cli {
namespace {

// The coordinate that stands for "no limit" in a box, metres: maps end long before it.
constexpr double kNoLimitM = 1e7;

// "1,2,3" as three numbers; so many, or with `times` a multiple of it.
absl::StatusOr<std::vector<double>> Numbers(const std::string& text, size_t count,
                                            const char* option, const char* form,
                                            bool times = false) {
  std::vector<double> numbers;
  for (absl::string_view part : absl::StrSplit(text, ',')) {
    double value = 0;
    if (!absl::SimpleAtod(part, &value)) break;
    numbers.push_back(value);
  }
  const bool are_all =
      std::count(text.begin(), text.end(), ',') + 1 == static_cast<long>(numbers.size());
  const bool fits = times ? numbers.size() % count == 0 : numbers.size() == count;
  if (are_all && fits && !numbers.empty()) return numbers;
  return absl::InvalidArgumentError(absl::StrCat(option, " is ", form, ", not '", text, "'"));
}

// As the server checks it: some formats are cut out of the box here, before it is sent.
absl::Status TakeBox(const std::vector<double>& v, RegionQuery& query) {
  v1::Box given;
  *given.mutable_min() = convert::ToMessage(Eigen::Vector3d(v[0], v[1], v[2]));
  *given.mutable_max() = convert::ToMessage(Eigen::Vector3d(v[3], v[4], v[5]));
  const auto box = convert::CheckedBox(given);
  if (!box.ok()) return box.status();
  query.box = *box;
  return absl::OkStatus();
}

absl::Status TakeOrientedBox(const std::string& text, RegionQuery& query) {
  const auto n = Numbers(text, 7, "--oriented-box", "x,y,z,yaw_deg,length,width,height");
  if (!n.ok()) return n.status();
  const double* v = n->data();
  query.shape = OrientedBox{Pose::FromXyzRpy(v[0], v[1], v[2], 0, 0, v[3] * kRadPerDeg),
                            Eigen::Vector3d(v[4], v[5], v[6])};
  return absl::OkStatus();
}

absl::Status TakePolygon(const std::string& text, RegionQuery& query) {
  const auto n = Numbers(text, 2, "--polygon", "x0,y0,x1,y1,x2,y2,...", /*times=*/true);
  if (!n.ok()) return n.status();
  Polygon polygon;
  for (size_t i = 0; i < n->size(); i += 2) polygon.corners.emplace_back((*n)[i], (*n)[i + 1]);
  query.shape = polygon;
  return absl::OkStatus();
}

absl::Status TakeCorridor(const std::string& text, double width_m, RegionQuery& query) {
  const auto n = Numbers(text, 3, "--corridor", "x0,y0,z0,x1,y1,z1,...", /*times=*/true);
  if (!n.ok()) return n.status();
  if (!(width_m > 0)) {
    return absl::InvalidArgumentError("--corridor needs --width, its full width in metres");
  }
  Corridor corridor;
  for (size_t i = 0; i < n->size(); i += 3) {
    corridor.path.emplace_back((*n)[i], (*n)[i + 1], (*n)[i + 2]);
  }
  corridor.width_m = width_m;
  query.shape = corridor;
  return absl::OkStatus();
}

absl::Status TakeShape(const RegionOptions& options, RegionQuery& query) {
  if (!options.oriented_box.empty()) return TakeOrientedBox(options.oriented_box, query);
  if (!options.polygon.empty()) return TakePolygon(options.polygon, query);
  if (!options.corridor.empty()) return TakeCorridor(options.corridor, options.width_m, query);
  return absl::OkStatus();
}

// Heights in the map, or relative to a corridor's path.
absl::Status TakeBand(const RegionOptions& options, RegionQuery& query) {
  if (std::isinf(options.min_z) && std::isinf(options.max_z)) return absl::OkStatus();
  if (!(options.min_z <= options.max_z)) {
    return absl::InvalidArgumentError(absl::StrCat("--min-z ", options.min_z, " is above --max-z ",
                                                   options.max_z, ": swap them"));
  }
  const HeightBand heights{options.min_z, options.max_z};
  if (auto* polygon = std::get_if<Polygon>(&query.shape)) {
    polygon->heights = heights;
    return absl::OkStatus();
  }
  if (auto* corridor = std::get_if<Corridor>(&query.shape)) {
    corridor->heights = heights;
    return absl::OkStatus();
  }
  Box box = query.box.value_or(
      Box{Eigen::Vector3d::Constant(-kNoLimitM), Eigen::Vector3d::Constant(kNoLimitM)});
  box.min.z() = std::max(box.min.z(), options.min_z);
  box.max.z() = std::min(box.max.z(), options.max_z);
  if (box.min.z() > box.max.z()) {
    return absl::InvalidArgumentError("--box leaves no height between --min-z and --max-z");
  }
  query.box = box;
  return absl::OkStatus();
}

}  // namespace

void AddRegionOptions(CLI::App& command, RegionOptions& options) {
  AddPlaceOptions(command, options);
  command.add_option("--robot", options.robot, "Only points of this robot");
  command
      .add_option("--class", options.classes,
                  "Only points of these classes: ground, ceiling, wall, pole, vegetation, vehicle, "
                  "object, structure, mover, unknown")
      ->delimiter(',');
}

void AddHeightOptions(CLI::App& command, RegionOptions& options, const std::string& also) {
  command
      .add_option("--min-z", options.min_z, absl::StrCat("Lowest height, metres in the map", also))
      ->check(Finite());
  command.add_option("--max-z", options.max_z, "Greatest height, likewise")->check(Finite());
}

void AddPlaceOptions(CLI::App& command, RegionOptions& options) {
  CLI::Option* box = command.add_option("--box", options.box, "x0,y0,z0,x1,y1,z1 in the map frame");
  CLI::Option* sphere =
      command.add_option("--sphere", options.sphere, "x,y,z,radius in the map frame");
  sphere->excludes(box);
  CLI::Option* oriented =
      command.add_option("--oriented-box", options.oriented_box,
                         "x,y,z,yaw_deg,length,width,height; x,y,z is its middle");
  CLI::Option* polygon = command.add_option("--polygon", options.polygon,
                                            "x0,y0,x1,y1,x2,y2,...: corners, seen from above");
  CLI::Option* corridor = command.add_option("--corridor", options.corridor,
                                             "x0,y0,z0,x1,y1,z1,...: the space along this path");
  command.add_option("--width", options.width_m, "Width of the corridor, metres")->needs(corridor);
  oriented->excludes(box)->excludes(sphere);
  polygon->excludes(box)->excludes(sphere)->excludes(oriented);
  corridor->excludes(box)->excludes(sphere)->excludes(oriented)->excludes(polygon);
  AddHeightOptions(command, options, "; for a corridor relative to its path");
  for (const char* name : {"--min-z", "--max-z"}) {
    command.get_option(name)->excludes(sphere)->excludes(oriented);
  }
  AddMapOption(command, options.query.component);
}

CLI::Option* AddMapOption(CLI::App& command, MapName& map, const std::string& help) {
  const auto take = [&map](const std::string& text) { map = MapName::FromText(text); };
  return command
      .add_option_function<std::string>("--map,--component", take,
                                        help +
                                            "Map: any session in it, a name that stays valid, or "
                                            "its present number; 0 is the largest")
      ->default_str("0");
}

absl::StatusOr<RegionQuery> ParseRegion(const RegionOptions& options) {
  RegionQuery query = options.query;
  if (!options.box.empty()) {
    const auto n = Numbers(options.box, 6, "--box", "x0,y0,z0,x1,y1,z1");
    if (!n.ok()) return n.status();
    const absl::Status taken = TakeBox(*n, query);
    if (!taken.ok()) return taken;
  }
  if (!options.sphere.empty()) {
    const auto n = Numbers(options.sphere, 4, "--sphere", "x,y,z,radius");
    if (!n.ok()) return n.status();
    query.sphere = {{(*n)[0], (*n)[1], (*n)[2]}, (*n)[3]};
  }
  if (absl::Status status = TakeShape(options, query); !status.ok()) return status;
  query.robot = RobotId(options.robot);
  query.wants_label = true;
  for (const std::string& name : options.classes) {
    const auto of = ParsePointClass(name);
    if (!of.ok()) return of.status();
    query.classes.push_back(*of);
  }
  if (absl::Status status = TakeBand(options, query); !status.ok()) return status;
  return query;
}

}  // namespace isthmus::cli
