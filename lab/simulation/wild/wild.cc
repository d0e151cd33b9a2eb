#include "lab/simulation/wild/wild.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/str_join.h>

#include <algorithm>
#include <utility>

#include "lab/simulation/wild/ride.h"
#include "lab/simulation/wild/scenes.h"

namespace isthmus::simulation {
namespace {

using wild::Carrier;
using wild::Gait;
using wild::Kind;

const std::vector<Kind>& Kinds() {
  using enum Gait;
  static const auto* const kinds = new std::vector<Kind>{
      {"road", {kCar, kCar, kCar, kWheels}, 15, wild::MakeRoad},
      {"forest", {kWheels, kLegs, kHand}, 4, wild::MakeForest},
      {"mine", {kWheels, kLegs, kHand, kCar}, 7, wild::MakeMine},
      {"tunnel", {kWheels, kLegs, kHand, kCar}, 15, wild::MakeTunnel},
      {"warehouse", {kWheels, kLegs, kHand}, 3, wild::MakeWarehouse},
      {"yard", {kWheels, kLegs, kHand, kCar}, 8, wild::MakeYard},
      {"field", {kWheels, kLegs, kHand, kCar}, 12, wild::MakeField},
      {"house", {kWheels, kLegs, kHand}, 1.8, wild::MakeHouse},
      {"plant", {kWheels, kLegs, kHand}, 2.5, wild::MakePlant},
      {"crowd", {kWheels, kLegs, kHand, kCar}, 8, wild::MakeCrowd},
      {"hotel", {kWheels, kLegs, kHand}, 1.5, wild::MakeHotel},
      {"inn", {kWheels, kLegs, kHand}, 1.5, wild::MakeInn},
      {"flat", {kWheels, kLegs, kHand}, 1.2, wild::MakeFlat},
      {"office", {kWheels, kLegs, kHand}, 1.5, wild::MakeOffice},
      {"storey", {kLegs, kLegs, kLegs, kHand, kWheels}, 1.5, wild::MakeStorey},
      {"carpark", {kWheels, kLegs, kHand, kCar}, 4, wild::MakeCarPark},
  };
  return *kinds;
}

// The sensors that worlds draw, by seed: a change of this list changes all worlds (kWildVersion).
const std::vector<std::string>& DrawnSensors() {
  static const auto* const names = new std::vector<std::string>{
      "vlp16",  "vlp32",  "hdl32",   "hdl64",  "vls128", "m8",      "os0-32", "os0-64", "os0-128",
      "os1-32", "os1-64", "os1-128", "os2-32", "os2-64", "os2-128", "solid",  "mid360", "mid70"};
  return *names;
}

absl::StatusOr<const Kind*> FindKind(const std::string& name) {
  for (const Kind& kind : Kinds()) {
    if (kind.name == name) return &kind;
  }
  return absl::InvalidArgumentError(absl::StrCat("no kind of wild world is called \"", name,
                                                 "\"; choose one of ",
                                                 absl::StrJoin(WildKinds(), ", ")));
}

}  // namespace

std::vector<std::string> WildKinds() {
  std::vector<std::string> names;
  for (const Kind& kind : Kinds()) names.push_back(kind.name);
  return names;
}

std::vector<std::string> FurnishedKinds() { return {"inn", "flat", "office", "storey", "carpark"}; }

absl::StatusOr<WildOptions> ChooseWild(uint64_t seed, const WildOptions& options) {
  if (!(options.seconds > 0 && options.seconds < 86400)) {
    return absl::InvalidArgumentError(absl::StrCat(
        "a wild drive takes more than 0 s and less than a day, not ", options.seconds));
  }
  WildOptions chosen = options;
  const auto choose = [&](uint64_t stream, const std::vector<std::string>& names,
                          std::string* name) {
    Random random(seed, 0x91, stream);
    if (name->empty()) *name = names[random.Index(static_cast<int>(names.size()))];
  };
  choose(0, WildKinds(), &chosen.kind);
  choose(1, DrawnSensors(), &chosen.sensor);
  if (const auto known = FindKind(chosen.kind); !known.ok()) return known.status();
  return chosen;
}

absl::StatusOr<WildDrive> DrawWildDrive(uint64_t seed, const WildOptions& any) {
  const auto options = ChooseWild(seed, any);
  if (!options.ok()) return options.status();
  const auto kind = FindKind(options->kind);
  if (!kind.ok()) return kind.status();
  auto lidar = MakeLidar(options->sensor);
  if (!lidar.ok()) return lidar.status();

  Random random(seed, 0x91, 2), world_random(seed, 0x91, 3), ride_random(seed, 0x91, 4);
  wild::Need need;
  need.carrier = Carrier::Draw((*kind)->gaits, (*kind)->top_mps, random);
  need.seconds = options->seconds;
  need.path_length_m = need.carrier.speed_mps * (options->seconds + 3);
  need.season = {.world = seed, .day = seed};
  wild::Scene scene = (*kind)->make(need, world_random);
  const wild::Way way{.begin_m = scene.begin_m};
  Random fault_random(seed, 0x91, 5);
  wild::Ridden ridden =
      wild::MakeRide(absl::StrCat(kWildPrefix, (*kind)->name), std::move(scene),
                     {need.carrier, *std::move(lidar), need.seconds, way, seed, options->truth},
                     ride_random, fault_random);
  return WildDrive{(*kind)->name, wild::NameOf(need.carrier.gait), std::move(ridden.about),
                   std::move(ridden.simulator)};
}

namespace {

// A carrier that suits a whole team: widest, highest and fastest, and it climbs if all can.
Carrier Envelope(const std::vector<Carrier>& team) {
  Carrier all = team.front();
  bool climb = true, car = false;
  for (const Carrier& carrier : team) {
    all.base_m = std::max(all.base_m, carrier.base_m);
    all.height_m = std::max(all.height_m, carrier.height_m);
    all.speed_mps = std::max(all.speed_mps, carrier.speed_mps);
    climb = climb && (carrier.gait == Gait::kLegs || carrier.gait == Gait::kHand);
    car = car || carrier.gait == Gait::kCar;
  }
  all.gait = car ? Gait::kCar : climb ? Gait::kLegs : Gait::kWheels;
  return all;
}

struct Stretch {
  double begin_m = 0, length_m = 0;
};

// Each robot's stretch of the path: the shorter ones somewhere in the longest one's stretch, or
// beyond its ends, all the farther the more the team is spread.
std::vector<Stretch> Spread(const std::vector<Carrier>& team, double seconds, Random& random) {
  std::vector<Stretch> stretches;
  double longest = 0;
  for (const Carrier& carrier : team) {
    longest = std::max(longest, carrier.speed_mps * (seconds + 3));
  }
  const double spread = random.Uniform(0, 1);
  for (const Carrier& carrier : team) {
    const double length = carrier.speed_mps * (seconds + 3);
    stretches.push_back({random.Unit() * (longest - length + spread * longest), length});
  }
  return stretches;
}

}  // namespace

absl::StatusOr<WildDrive> DrawWildTeamDrive(uint64_t seed, const WildTeam& team, int robot) {
  const auto options = ChooseWild(seed, {team.kind, "vlp16", team.seconds});
  if (!options.ok()) return options.status();
  const auto kind = FindKind(options->kind);
  if (!kind.ok()) return kind.status();
  if (robot < 0 || robot >= team.robots) {
    return absl::InvalidArgumentError(
        absl::StrCat("there is no robot ", robot, " in a team of ", team.robots));
  }
  const auto stream = [&](uint64_t which) { return Random(seed, 0x92 + which, robot); };
  Random sensor_random = stream(0), way_random = stream(1), day_random = stream(2);
  const std::vector<std::string>& sensors = DrawnSensors();
  const std::string& drawn = sensors[sensor_random.Index(static_cast<int>(sensors.size()))];
  auto lidar = MakeLidar(team.sensor.empty() ? drawn : team.sensor);
  if (!lidar.ok()) return lidar.status();

  std::vector<Carrier> carriers;
  for (int i = 0; i < team.robots; ++i) {
    Random random(seed, 0x98, i);
    carriers.push_back(Carrier::Draw((*kind)->gaits, (*kind)->top_mps, random));
  }
  Random spread_random(seed, 0x99, 0), world_random(seed, 0x91, 3);
  const std::vector<Stretch> stretches = Spread(carriers, team.seconds, spread_random);
  wild::Need need;
  need.carrier = Envelope(carriers);
  need.seconds = team.seconds;
  for (const Stretch& s : stretches) {
    need.path_length_m = std::max(need.path_length_m, s.begin_m + s.length_m);
  }
  need.robots = team.robots;
  need.bare = team.bare;
  const bool same_day = day_random.Chance(0.4) || team.first_day;
  need.season = {.world = seed, .day = day_random.Next()};
  if (!same_day) {
    need.season.changed = day_random.Uniform(0.1, 0.6);
    need.season.leaves = day_random.Unit();
  }
  if (team.twin == WildTwin::kRefurnished) need.season.changed = 1;
  wild::Scene scene = (*kind)->make(need, world_random);

  wild::Way way{.begin_m = scene.begin_m + stretches[robot].begin_m};
  way.backwards = way_random.Chance(0.4);
  way.left_m = way_random.Uniform(-0.3, 0.3);
  way.above_m = way_random.Index(scene.storeys) * scene.storey_m;
  if (way.backwards) {
    way.begin_m = scene.path->length() - way.begin_m - stretches[robot].length_m;
    way.left_m -= scene.oncoming_left_m;
    if (scene.oncoming_left_m != 0) scene.cars.clear();  // They would come head-on.
  }
  if (!scene.ways.empty()) {
    scene.path = scene.ways[static_cast<size_t>(robot)];
    way = {.begin_m = scene.begin_m, .above_m = way.above_m};
  }
  Random ride_random = stream(3), fault_random = stream(4);
  const uint64_t noise = stream(5).Next();
  const wild::Carrier& carrier = carriers[robot];
  wild::Ridden ridden = wild::MakeRide(
      absl::StrCat(kWildPrefix, (*kind)->name), std::move(scene),
      {carrier, *std::move(lidar), team.seconds, way, noise, team.truth, team.further}, ride_random,
      fault_random);
  absl::StrAppend(&ridden.about, way.backwards ? ", backwards" : "",
                  same_day ? "" : ", another day");
  return WildDrive{(*kind)->name,           wild::NameOf(carrier.gait),
                   std::move(ridden.about), std::move(ridden.simulator),
                   ridden.further_m,        ridden.blocked};
}

}  // namespace isthmus::simulation
