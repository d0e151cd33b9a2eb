#include "lab/bench/merging/odom_frames.h"

#include <cmath>
#include <memory>
#include <numbers>
#include <utility>
#include <vector>

namespace isthmus::bench {
namespace {

constexpr double kDegree = std::numbers::pi / 180;
constexpr double kFarM = 200, kHighM = 10, kTilt = 5 * kDegree;

// moves[i] * odom is the new odom frame as submap i sees it.
void Move(const std::vector<Pose>& moves, DrivenRobot* robot) {
  for (size_t i = 0; i < moves.size(); ++i) {
    auto moved = std::make_shared<Submap>(*robot->submaps[i]);
    moved->T_odom_submap = moves[i] * moved->T_odom_submap;
    robot->submaps[i] = std::move(moved);
  }
  for (ScanPose& pose : robot->poses) {
    // The last scans may be in a submap that was never cut.
    const size_t i = std::min<size_t>(pose.submap, moves.size() - 1);
    pose.T_odom_sensor = moves[i] * pose.T_odom_sensor;
  }
}

}  // namespace

Pose RandomFrame(uint64_t seed, int robot) {
  simulation::Random random(seed, 0x0D, static_cast<uint64_t>(robot));
  const double yaw = random.Uniform(-std::numbers::pi, std::numbers::pi);
  const double roll = random.Uniform(-kTilt, kTilt), pitch = random.Uniform(-kTilt, kTilt);
  const double towards = random.Uniform(-std::numbers::pi, std::numbers::pi);
  const double far = random.Uniform(0, kFarM);
  return Pose::FromXyzRpy(far * std::cos(towards), far * std::sin(towards),
                          random.Uniform(-kHighM, kHighM), roll, pitch, yaw);
}

void MoveOdom(const Pose& T_new_odom, DrivenRobot* robot) {
  if (!robot->submaps.empty()) Move(std::vector(robot->submaps.size(), T_new_odom), robot);
}

Pose DriftOf(const DriftOptions& drift, double length_m, simulation::Random& random) {
  const double metres = drift.percent / 100 * length_m;
  const double yaw = drift.deg_per_m * kDegree * length_m;
  const double x = metres * random.Normal(), y = metres * random.Normal();
  const double z = metres / 3 * random.Normal();
  return Pose::FromXyzRpy(x, y, z, 0, 0, yaw * random.Normal());
}

void AddDrift(const DriftOptions& drift, uint64_t seed, DrivenRobot* robot) {
  if (robot->submaps.empty()) return;
  simulation::Random random(seed, 0xD2, robot->submaps.size());
  std::vector<Pose> moves(1);
  Pose T_new_submap = robot->submaps[0]->T_odom_submap;
  for (size_t i = 1; i < robot->submaps.size(); ++i) {
    const Pose step =
        robot->submaps[i - 1]->T_odom_submap.Inverse() * robot->submaps[i]->T_odom_submap;
    T_new_submap = T_new_submap * step * DriftOf(drift, step.translation().norm(), random);
    moves.push_back(T_new_submap * robot->submaps[i]->T_odom_submap.Inverse());
  }
  Move(moves, robot);
}

}  // namespace isthmus::bench
