// Errors of estimated trajectories.
#pragma once

#include <absl/status/statusor.h>

#include <cstddef>
#include <string>
#include <vector>

#include "client/evaluation/statistics.h"
#include "core/map/trajectory.h"
#include "core/pose.h"

namespace isthmus::evaluation {

// Statistics of the distances between true and estimated positions, metres; of the angles between
// true and estimated orientations, degrees.
struct ErrorStatistics {
  size_t count = 0;   // Poses compared.
  double rmse_m = 0;  // sqrt(1/n sum |p_true - p_estimated|^2), eq. 3 of the paper.
  double mean_m = 0;
  double median_m = 0;
  double std_m = 0;
  double min_m = 0, max_m = 0;
  Statistics rotation_deg = {};
};

// One robot: the same sensor's poses in two frames.
struct TrajectoryPair {
  std::string name;  // For messages.
  Trajectory truth;
  Trajectory estimate;
};

enum class Alignment {
  kNone,       // Both are in one frame already.
  kFirstPose,  // The first pair of poses of the first robot is made to coincide.
  kRigid,      // Least squares over all positions, no scale: Umeyama, "Least-squares estimation of
               // transformation parameters between two point patterns", PAMI 1991, eqs. 40-42.
};

struct TrajectoryErrors {
  Pose T_truth_estimate;  // The one alignment, common to all robots.
  ErrorStatistics all;    // Over the poses of all robots.
  std::vector<ErrorStatistics> robots;
};

// Compares each estimated pose with the true one nearest in time, see Associate.
// Several robots are judged as one merged map: they share one alignment, so that a robot that is
// right in itself but wrongly placed among the others counts as wrong. For each robot by itself
// call this once per robot. Trajectories need not be in order of time.
// InvalidArgument, naming the robot and what to do, if a robot has no stamps in common, or
// kRigid is asked for fewer than 3 poses.
absl::StatusOr<TrajectoryErrors> CompareTrajectories(const std::vector<TrajectoryPair>& pairs,
                                                     Alignment alignment = Alignment::kRigid,
                                                     double tolerance_s = 0.02);

}  // namespace isthmus::evaluation
