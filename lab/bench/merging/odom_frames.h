// Substitute odometry for recorded drives: frames that lie anywhere, and drift. Submaps stay as
// they are and their poses move; the scans' poses move with their submaps.
#pragma once

#include <cstdint>

#include "lab/bench/merging/driven_robot.h"
#include "lab/simulation/random.h"

namespace isthmus::bench {

// A frame as of a robot with its own SLAM: any yaw, up to 5 degrees of roll and of pitch, up to
// 200 m away and 10 m up or down. Uniform in each; deterministic.
Pose RandomFrame(uint64_t seed, int robot);

// Makes T_new_odom * odom the robot's odom frame.
void MoveOdom(const Pose& T_new_odom, DrivenRobot* robot);

// A random walk from submap to submap: the errors of each step are normal, with standard deviations
// in proportion to its length.
struct DriftOptions {
  double percent = 0;    // Share of the length, along x and along y; a third of it in height.
  double deg_per_m = 0;  // About the vertical axis.
};

// The error of a step of `length_m`; multiply it from the right.
Pose DriftOf(const DriftOptions& drift, double length_m, simulation::Random& random);

void AddDrift(const DriftOptions& drift, uint64_t seed, DrivenRobot* robot);

}  // namespace isthmus::bench
