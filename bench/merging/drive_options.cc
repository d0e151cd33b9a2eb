#include "bench/merging/drive_options.h"

#include <absl/strings/str_cat.h>

#include <memory>
#include <numbers>
#include <utility>

#include "client/simulation/simulator.h"

namespace isthmus::bench {

std::string DriveOptions::Key() const {
  std::string key = absl::StrCat(Ground(), "-", seconds, "s-", robot, "of", robots, "-", sensor);
  if (walkers > 0) absl::StrAppend(&key, "-walkers", walkers);
  if (cars > 0) absl::StrAppend(&key, "-cars", cars);
  if (tilt_deg != 0) absl::StrAppend(&key, "-tilt", tilt_deg);
  return key;
}

std::string DriveOptions::Ground() const { return absl::StrCat(world, "-", seed); }

absl::StatusOr<GroundedDrive> SimulateDrive(const DriveOptions& options) {
  simulation::Options simulated;
  simulated.world = options.world;
  simulated.sensor = options.sensor;
  simulated.seed = options.seed;
  simulated.seconds = options.seconds;
  simulated.robots = options.robots;
  simulated.walkers = options.walkers;
  simulated.cars = options.cars;
  auto level = simulation::Simulator::Create(simulated);
  if (!level.ok()) return level.status();
  std::shared_ptr<const simulation::Simulator> simulator = *std::move(level);
  if (options.tilt_deg != 0) {
    const double tilt = options.tilt_deg * std::numbers::pi / 180;
    const Pose T_level_sensor = Pose::FromXyzRpy(0, 0, 0, tilt, -tilt, 0);
    std::vector<simulation::Motion> motions;
    for (int robot = 0; robot < simulator->robots(); ++robot) {
      motions.emplace_back([simulator, robot, T_level_sensor](double seconds) {
        return simulator->PoseAt(robot, seconds) * T_level_sensor;
      });
    }
    simulator = std::make_shared<const simulation::Simulator>(
        simulator->world(), std::move(motions), simulator->lidar(), simulator->options());
  }
  GroundedDrive grounded;
  grounded.ground = options.Ground();
  grounded.overlap_cell_m = simulator->world().overlap_cell_m;
  Drive& drive = grounded.drive;
  drive.sensor = options.sensor;
  for (int turn = 0; turn < simulator->scan_count(); ++turn) {
    drive.shots.push_back({turn, simulator->Truth(options.robot, turn).stamp_ns});
  }
  drive.scan_of = [simulator, robot = options.robot](int turn) {
    return simulator->MakeScan(robot, turn);
  };
  drive.truth_of = [simulator, robot = options.robot](int turn) {
    return simulator->Truth(robot, turn).pose;
  };
  return grounded;
}

}  // namespace isthmus::bench
