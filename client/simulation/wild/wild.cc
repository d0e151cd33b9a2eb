#include "client/simulation/wild/wild.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>
#include <absl/strings/str_join.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "client/simulation/wild/faults.h"
#include "client/simulation/wild/scenes.h"

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
  };
  return *kinds;
}

absl::StatusOr<const Kind*> FindKind(const std::string& name) {
  for (const Kind& kind : Kinds()) {
    if (kind.name == name) return &kind;
  }
  return absl::InvalidArgumentError(absl::StrCat("no kind of wild world is called \"", name,
                                                 "\"; choose one of ",
                                                 absl::StrJoin(WildKinds(), ", ")));
}

// People come no nearer to the robot than `distance_m`; the nearer, the more they give way.
Motion GivingWay(Motion walk, Motion robot, double distance_m) {
  return [=](double t) {
    const Pose at = walk(t);
    const Eigen::Vector2d robot_at = robot(t).translation().head<2>();
    const Eigen::Vector2d off = at.translation().head<2>() - robot_at;
    const double apart = std::max(off.norm(), 1e-6);
    const Eigen::Vector2d moved = robot_at + std::hypot(apart, distance_m) / apart * off;
    return Pose(at.rotation(), {moved.x(), moved.y(), at.translation().z()});
  };
}

// Kerbs that are driven up and down again, humps, sills: too low to be seen as more than noise.
void AddBumps(const Carrier& carrier, wild::Path* path, Random& random) {
  const bool wheels = carrier.gait == Gait::kWheels || carrier.gait == Gait::kCar;
  const double every = random.Uniform(5, 80);
  const double highest = random.Uniform(0.02, 0.12) * std::min(1.0, 1.5 / carrier.speed_mps);
  if (!wheels || random.Chance(0.5)) return;
  for (double s = every; s + 10 < path->length(); s += every * random.Uniform(0.3, 1.7)) {
    const double length = 2 * carrier.base_m + (random.Chance(0.5) ? 0 : random.Uniform(0, 5));
    path->Raise(s, s + length, highest * random.Unit(), carrier.base_m);
  }
}

wild::CarrierMotion DrawCarrierMotion(const wild::Need& need, wild::Scene* scene, Random& random) {
  AddBumps(need.carrier, scene->path.get(), random);
  const auto timetable = std::make_shared<const wild::Timetable>(
      *scene->path, need.carrier, scene->begin_m, need.seconds, random);
  return wild::CarrySensor(scene->path, timetable, need.carrier, random);
}

std::string Describe(const Carrier& carrier, const wild::Faults& faults) {
  const Eigen::Vector3d up = carrier.T_base_sensor.rotation() * Eigen::Vector3d::UnitZ();
  const double tilt = std::acos(std::clamp(up.z(), -1.0, 1.0)) * 180 / std::numbers::pi;
  return absl::StrFormat("%.1f m/s, sensor at %.1f m, %.0f deg%s", carrier.speed_mps,
                         carrier.height_m, tilt, faults.about);
}

}  // namespace

std::vector<std::string> WildKinds() {
  std::vector<std::string> names;
  for (const Kind& kind : Kinds()) names.push_back(kind.name);
  return names;
}

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
  choose(1, LidarNames(), &chosen.sensor);
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
  wild::Scene scene = (*kind)->make(need, world_random);
  const wild::CarrierMotion carrier_motion = DrawCarrierMotion(need, &scene, ride_random);
  Actors actors{{}, std::move(scene.cars)};
  for (Motion& walk : scene.walks) {
    actors.walks.push_back(GivingWay(std::move(walk), carrier_motion.base, scene.give_way_m));
  }
  Random fault_random(seed, 0x91, 5);
  const wild::Faults faults = wild::DrawFaults(need.carrier, fault_random);
  World world;
  world.name = absl::StrCat("wild-", (*kind)->name);
  world.mesh = std::move(scene.mesh);
  const Options simulated{.world = world.name,
                          .sensor = lidar->name,
                          .robots = 1,
                          .seconds = options->seconds,
                          .seed = seed,
                          .noise = faults.noise,
                          .effects = faults.effects};
  WildDrive drive{(*kind)->name, wild::NameOf(need.carrier.gait), Describe(need.carrier, faults),
                  nullptr};
  drive.simulator =
      std::make_unique<Simulator>(std::move(world), std::vector<Motion>{carrier_motion.sensor},
                                  std::move(actors), *std::move(lidar), simulated);
  return drive;
}

}  // namespace isthmus::simulation
