#include "bench/merging/pair.h"

#include <numbers>
#include <utility>
#include <vector>

namespace isthmus::bench {
namespace {

using simulation::Simulator;

absl::StatusOr<std::shared_ptr<const Simulator>> Simulate(const PairOptions& options,
                                                          const std::string& world) {
  simulation::Options simulation;
  simulation.world = world;
  simulation.seed = options.seed;
  simulation.seconds = options.seconds;
  simulation.walkers = options.walkers;
  auto simulator = Simulator::Create(simulation);
  if (!simulator.ok()) return simulator.status();
  return std::shared_ptr<const Simulator>(*std::move(simulator));
}

// The same world and drives, all sensors mounted askew.
std::shared_ptr<const Simulator> Tilted(std::shared_ptr<const Simulator> level, double tilt_deg) {
  const double tilt = tilt_deg * std::numbers::pi / 180;
  const Pose T_level_sensor = Pose::FromXyzRpy(0, 0, 0, tilt, -tilt, 0);
  std::vector<simulation::Motion> motions;
  for (int robot = 0; robot < level->robots(); ++robot) {
    motions.emplace_back([level, robot, T_level_sensor](double seconds) {
      return level->PoseAt(robot, seconds) * T_level_sensor;
    });
  }
  return std::make_shared<const Simulator>(level->world(), std::move(motions), level->lidar(),
                                           level->options());
}

}  // namespace

absl::StatusOr<Pair> Pair::Make(const PairOptions& options) {
  Pair pair;
  auto a = Simulate(options, options.world_a);
  if (!a.ok()) return a.status();
  pair.a_ = pair.b_ = *std::move(a);
  if (!options.world_b.empty()) {
    auto b = Simulate(options, options.world_b);
    if (!b.ok()) return b.status();
    pair.b_ = *std::move(b);
    pair.same_world_ = false;
  }
  if (options.tilt_deg != 0) pair.b_ = Tilted(pair.b_, options.tilt_deg);
  return pair;
}

}  // namespace isthmus::bench
