#include "lab/bench/merging/drive_options.h"

#include <absl/strings/escaping.h>
#include <absl/strings/match.h>
#include <absl/strings/str_cat.h>

#include <memory>
#include <numbers>
#include <utility>
#include <vector>

#include "core/io/sha256.h"
#include "lab/simulation/simulator.h"

namespace isthmus::bench {

using simulation::Truth;
using simulation::WildTwin;

namespace {

std::string KeyOf(const std::vector<Eigen::Vector3d>& way) {
  const std::string hash = io::Sha256(way.data(), way.size() * sizeof(way[0]));
  return absl::StrCat("-way", absl::BytesToHexString(hash.substr(0, 8)));
}

}  // namespace

std::string DriveOptions::Key() const {
  std::string key = absl::StrCat(Ground(), "-", seconds, "s-", robot, "of", robots, "-", sensor);
  if (walkers > 0) absl::StrAppend(&key, "-walkers", walkers);
  if (cars > 0) absl::StrAppend(&key, "-cars", cars);
  if (parked > 0) absl::StrAppend(&key, "-parked", parked);
  if (day > 1) absl::StrAppend(&key, "-day", day, "-moved", moved);
  if (truth == Truth::kMoving) absl::StrAppend(&key, "-moving");
  if (truth == Truth::kClass) absl::StrAppend(&key, "-classes");
  if (tilt_deg != 0) absl::StrAppend(&key, "-tilt", tilt_deg);
  if (laps > 0) absl::StrAppend(&key, "-laps", laps);
  if (speed_mps > 0) absl::StrAppend(&key, "-", speed_mps, "mps");
  if (first_day) absl::StrAppend(&key, "-first");
  for (const simulation::Further& on : further) {
    absl::StrAppend(&key, "-after", on.after_scans,
                    on.way.empty() ? absl::StrCat("-along", on.along_m) : KeyOf(on.way));
  }
  if (absl::StartsWith(world, simulation::kWildPrefix))
    absl::StrAppend(&key, "-v", simulation::kWildVersion);
  return key;
}

std::string DriveOptions::Ground() const {
  return absl::StrCat(world, "-", seed,
                      twin == WildTwin::kRefurnished ? "-twin"
                      : twin == WildTwin::kExact     ? "-copy"
                                                     : "",
                      bare ? "-bare" : "");
}

namespace {

simulation::Options SimulationOf(const DriveOptions& options) {
  simulation::Options simulated;
  simulated.world = options.world;
  simulated.sensor = options.sensor;
  simulated.seed = options.seed;
  simulated.seconds = options.seconds;
  simulated.robots = options.robots;
  simulated.walkers = options.walkers;
  simulated.cars = options.cars;
  simulated.parked = options.parked;
  simulated.day = options.day;
  simulated.moved = options.moved;
  simulated.truth = options.truth;
  return simulated;
}

using simulation::Motion;
using simulation::Simulator;
using SharedSimulator = std::shared_ptr<const Simulator>;

struct Simulated {
  SharedSimulator simulator;
  double further_m = 0;
  bool blocked = false;
};

// Around and around, or on the tour at another speed.
absl::StatusOr<SharedSimulator> OnOtherWays(const Simulator& usual, const DriveOptions& options) {
  simulation::World world = usual.world();
  simulation::Options simulated = usual.options();
  if (options.speed_mps > 0) world.max_speed_mps = options.speed_mps;
  absl::StatusOr<std::vector<Motion>> motions;
  if (options.laps > 0) {
    const auto lap =
        simulation::MakeLap(world, options.seconds, usual.lidar().period_s, options.seed,
                            {.robots = options.robots, .robot = options.robot});
    if (!lap.ok()) return lap.status();
    motions = std::vector<Motion>(options.robots, lap->motion);  // Only its own is asked for.
    simulated.seconds = lap->begin_s + options.laps * lap->seconds;
  } else {
    motions = simulation::MakeRoutes(world, options.robots, options.seconds, options.seed);
    if (!motions.ok()) return motions.status();
  }
  return std::make_shared<const Simulator>(std::move(world), *std::move(motions), usual.lidar(),
                                           simulated);
}

SharedSimulator Tilted(const SharedSimulator& level, double tilt_deg) {
  const double tilt = tilt_deg * std::numbers::pi / 180;
  const Pose T_level_sensor = Pose::FromXyzRpy(0, 0, 0, tilt, -tilt, 0);
  std::vector<Motion> motions;
  motions.reserve(static_cast<size_t>(level->robots()));
  for (int robot = 0; robot < level->robots(); ++robot) {
    motions.emplace_back([level, robot, T_level_sensor](double seconds) {
      return level->PoseAt(robot, seconds) * T_level_sensor;
    });
  }
  return std::make_shared<const Simulator>(level->world(), std::move(motions), level->lidar(),
                                           level->options());
}

// Its simulator has this robot only.
absl::StatusOr<Simulated> OneOfWildTeam(const DriveOptions& options) {
  simulation::WildTeam team;
  team.kind = options.world.substr(simulation::kWildPrefix.size());
  team.sensor = options.sensor;
  team.robots = options.robots;
  team.seconds = options.seconds;
  team.twin = options.twin;
  team.bare = options.bare;
  team.first_day = options.first_day;
  team.truth = options.truth;
  team.further = options.further;
  auto drive = simulation::DrawWildTeamDrive(options.seed, team, options.robot);
  if (!drive.ok()) return drive.status();
  return Simulated{std::move(drive->simulator), drive->further_m, drive->blocked};
}

absl::StatusOr<Simulated> Simulate(const DriveOptions& options) {
  if (absl::StartsWith(options.world, simulation::kWildPrefix)) return OneOfWildTeam(options);
  auto usual = Simulator::Create(SimulationOf(options));
  if (!usual.ok()) return usual.status();
  return Simulated{*std::move(usual)};
}

}  // namespace

absl::StatusOr<GroundedDrive> SimulateDrive(const DriveOptions& options) {
  const auto usual = Simulate(options);
  if (!usual.ok()) return usual.status();
  SharedSimulator simulator = usual->simulator;
  if (options.laps > 0 || options.speed_mps > 0) {
    auto other = OnOtherWays(*simulator, options);
    if (!other.ok()) return other.status();
    simulator = *std::move(other);
  }
  if (options.tilt_deg != 0) simulator = Tilted(simulator, options.tilt_deg);
  GroundedDrive grounded;
  grounded.ground = options.Ground();
  grounded.overlap_cell_m = simulator->world().overlap_cell_m;
  grounded.further_m = usual->further_m;
  grounded.blocked = usual->blocked;
  Drive& drive = grounded.drive;
  drive.sensor = options.sensor;
  const int robot = simulator->robots() == 1 ? 0 : options.robot;
  for (int turn = 0; turn < simulator->scan_count(); ++turn) {
    drive.shots.push_back({turn, simulator->Truth(robot, turn).stamp_ns});
  }
  drive.scan_of = [simulator, robot](int turn) { return simulator->MakeScan(robot, turn); };
  drive.truth_of = [simulator, robot](int turn) { return simulator->Truth(robot, turn).pose; };
  return grounded;
}

}  // namespace isthmus::bench
