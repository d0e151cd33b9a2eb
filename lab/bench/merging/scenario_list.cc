#include "lab/bench/merging/scenario_list.h"

#include <absl/strings/str_cat.h>

#include <algorithm>

namespace isthmus::bench {
namespace {

constexpr double kMuseumS = 60, kCampusS = 120, kCampusWideS = 400;
constexpr OverlapRange kLittle{0.15, 0.25}, kNothing{0, 0.02};

// Robots of one world, all alike.
std::vector<DriveOptions> Team(const DriveOptions& each) {
  std::vector<DriveOptions> robots;
  for (int i = 0; i < each.robots; ++i) {
    robots.push_back(each);
    robots.back().robot = i;
  }
  return robots;
}

DriveOptions In(const std::string& world, double seconds) {
  return {.world = world, .seed = 0, .seconds = seconds};
}

std::vector<DriveOptions> Pair(const std::string& world, double seconds) {
  return Team(In(world, seconds));
}

std::vector<DriveOptions> Busy(const std::string& world, double seconds, int walkers,
                               int cars = 0) {
  DriveOptions each = In(world, seconds);
  each.walkers = walkers;
  each.cars = cars;
  return Team(each);
}

std::vector<DriveOptions> Tilted(std::vector<DriveOptions> robots, double tilt_deg) {
  robots[1].tilt_deg = tilt_deg;
  return robots;
}

// The second robot has another sensor.
std::vector<DriveOptions> Mixed(std::vector<DriveOptions> robots, const std::string& sensor) {
  robots[1].sensor = sensor;
  return robots;
}

std::vector<DriveOptions> Four(const std::string& world, double seconds) {
  DriveOptions each = In(world, seconds);
  each.robots = 4;
  return Team(each);
}

// Round a tour of `seconds` twice and back to where it began.
std::vector<DriveOptions> Laps(const std::string& world, double seconds) {
  DriveOptions each = In(world, seconds);
  each.laps = 2;
  return Team(each);
}

// The first robot of one pair and the second of the other.
std::vector<DriveOptions> Apart(const std::vector<DriveOptions>& a,
                                const std::vector<DriveOptions>& b) {
  return {a[0], b[1]};
}

// The same robots in worlds of other seeds.
std::vector<DriveOptions> Elsewhere(std::vector<DriveOptions> robots) {
  for (DriveOptions& robot : robots) ++robot.seed;
  return robots;
}

std::vector<MergingScenario> MakeScenarios() {
  const auto museum = Pair("museum", kMuseumS), campus = Pair("campus", kCampusS);
  const auto twins = Pair("twins", 40);
  return {
      {"museum", museum},
      {"campus", campus},
      {"campus_wide", Pair("campus_wide", kCampusWideS)},
      {"museum_short", museum, {}, kLittle},
      {"campus_short", campus, {}, kLittle},
      {"museum_apart", museum, {}, kNothing},
      {"campus_apart", campus, {}, kNothing},
      {"museum_drift", museum, {1, 0.1}},
      {"campus_drift", campus, {0.5, 0.02}},
      {"museum_laps_drift", Laps("museum", 40), {2, 0.2}},
      {"campus_laps_drift", Laps("campus", 60), {1, 0.1}},
      {"twins", twins},
      {"twins_large", Pair("twins_large", kMuseumS)},
      {"twins_wings", Pair("twins_wings", 100)},
      {"twins_joined", Pair("twins_joined", 80)},
      {"twins_joined_drift", Pair("twins_joined", 80), {1, 0.1}},
      {"museum_or_museum", Apart(museum, Elsewhere(museum))},
      {"campus_or_campus", Apart(campus, Elsewhere(campus))},
      {"museum_or_campus", Apart(museum, Pair("campus", kMuseumS))},
      {"museum_or_twins", Apart(museum, twins)},
      {"museum_or_corridor", Apart(museum, Pair("corridor", kMuseumS))},
      {"museum_walkers", Busy("museum", kMuseumS, 12)},
      {"campus_walkers", Busy("campus", kCampusS, 30)},
      {"campus_cars", Busy("campus", kCampusS, 30, 20)},
      {"museum_tilted", Tilted(museum, 5)},
      {"museum_mixed", Mixed(museum, "hdl64")},
      {"campus_mixed", Mixed(campus, "hdl64")},
      {"museum_mixed_os1", Mixed(museum, "os1-64")},
      {"campus_mixed_os1", Mixed(campus, "os1-64")},
      {"campus_4", Four("campus", kCampusS)},
      {"campus_4_drift", Four("campus", kCampusS), {0.5, 0.02}},
  };
}

}  // namespace

const std::vector<MergingScenario>& MergingScenarios() {
  static const auto* const scenarios = new std::vector(MakeScenarios());
  return *scenarios;
}

absl::StatusOr<std::vector<MergingScenario>> FindMergingScenarios(
    const std::vector<std::string>& names) {
  if (names.empty()) return MergingScenarios();
  std::vector<MergingScenario> found;
  for (const std::string& name : names) {
    const auto& all = MergingScenarios();
    const auto it = std::find_if(all.begin(), all.end(),
                                 [&](const MergingScenario& s) { return s.name == name; });
    if (it == all.end()) {
      return absl::InvalidArgumentError(
          absl::StrCat("no scenario is called \"", name, "\" (see --list)"));
    }
    found.push_back(*it);
  }
  return found;
}

}  // namespace isthmus::bench
