// Wild drives: worlds, carriers, sensors and their faults, all drawn at random.
#pragma once

#include <absl/status/statusor.h>
#include <absl/strings/string_view.h>

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "lab/simulation/simulator.h"
#include "lab/simulation/wild/further.h"

namespace isthmus::simulation {

// Drives of one version are not those of another; to be raised with every change of what is drawn.
constexpr int kWildVersion = 8;

// Names of wild worlds begin with it, before the kind.
inline constexpr absl::string_view kWildPrefix = "wild-";

struct WildOptions {
  std::string kind;    // One of WildKinds; empty: drawn.
  std::string sensor;  // See MakeLidar; empty: drawn.
  double seconds = 60;
  Truth truth = Truth::kNone;
};

// A drive as it was drawn.
struct WildDrive {
  std::string kind, carrier;
  std::string about;                     // Speed, height, tilt and effects, for people.
  std::unique_ptr<Simulator> simulator;  // One robot's.
  double further_m = 0;                  // Way of the last of WildTeam::further,
  bool blocked = false;                  // which ended before something solid.
};

// The options with the kind and the sensor that are drawn in place of empty ones. Errors as
// DrawWildDrive.
absl::StatusOr<WildOptions> ChooseWild(uint64_t seed, const WildOptions& options);

// The same seed and options give the same drive on every machine: naming the kind or the sensor
// that would be drawn changes nothing. The path is free of what stands in the world; people and
// cars give way. InvalidArgument, listing what there is, for a kind or sensor that is not known and
// for seconds that are not above 0 and below a day.
absl::StatusOr<WildDrive> DrawWildDrive(uint64_t seed, const WildOptions& options);

// The world itself, or one that is built alike. Poses are as if it were the world itself: nobody's
// map of the one is to be joined with a map of the other.
enum class WildTwin {
  kNone,
  kRefurnished,  // Nothing loose is the same.
  kExact,        // All is the same.
};

// Several robots in one world, each at its own time and with a carrier, a sensor and faults of its
// own: on stretches of one way that may overlap, some of them in the other direction, or in
// furnished buildings each on a way of its own through some of the rooms; on another storey where
// storeys are alike; or on another day, with part of what stands about gone or moved.
struct WildTeam {
  std::string kind, sensor;  // As in WildOptions.
  int robots = 2;
  double seconds = 60;
  WildTwin twin = WildTwin::kNone;
  bool bare = false;       // Walls only, in FurnishedKinds.
  bool first_day = false;  // All on the day on which the world was made.
  Truth truth = Truth::kNone;
  // The robot that is drawn goes on like that, one after the other: the drive is as long as that
  // takes. All that went before stays the same; cars do not give way to it.
  std::vector<Further> further = {};
};

// The drive of one robot of the team. As DrawWildDrive; InvalidArgument also for a robot that is
// not of the team.
absl::StatusOr<WildDrive> DrawWildTeamDrive(uint64_t seed, const WildTeam& team, int robot);

// Names of the kinds:
//   road       guard rails, few poles, hills       forest     trunks, bushes, rough ground
//   mine       rooms and pillars of rough rock     tunnel     bends, alcoves, smooth to rough
//   warehouse  racks                               yard       stacks of containers
//   field      one building, grass, few trees      house      storeys, ramps or stairs, glass
//   plant      pipes, vessels, frames              crowd      people and cars before house fronts
//   hotel      rooms and storeys built and furnished alike
//   inn        the same, but beds, desks, chairs and curtains are as their guests left them
//   flat       40 to 120 m2: two to five rooms on a corridor
//   office     200 to 2000 m2: cells, meeting rooms and open-plan offices
//   storey     two or three storeys of 40 x 20 m with stairs, alike but for their furniture
//   carpark    decks with ramps, cars in 40 to 80 % of the bays
// From inn on there are people who walk about.
std::vector<std::string> WildKinds();

// Kinds in which furniture, or parked cars, can be left out; see WildTeam::bare.
std::vector<std::string> FurnishedKinds();

}  // namespace isthmus::simulation
