// A comparison of estimated trajectories with the truth, by all errors that people quote.
#pragma once

#include <absl/status/statusor.h>

#include <optional>
#include <string>
#include <vector>

#include "client/evaluation/association.h"
#include "client/evaluation/relative_error.h"
#include "client/evaluation/trajectory_error.h"

namespace isthmus::evaluation {

struct EvaluationOptions {
  Alignment alignment = Alignment::kRigid;
  double tolerance_s = 0.02;              // Between stamps that belong together, at most.
  bool merged = false;                    // The estimates are in one frame and get one alignment.
  Delta delta = {1, DeltaUnit::kMetres};  // For per_delta.
};

struct EvaluatedTrajectory {
  std::string name;
  Trajectory truth;             // All of it, in its own frame.
  size_t estimate_poses = 0;    // As given; how many were compared: pairs.size().
  std::vector<PosePair> pairs;  // In order of time, the estimates moved into the truth's frame.
  double way_m = 0;             // Along the truth, from the first pair to the last.
  double duration_s = 0;        // Along the same way.
  Pose T_truth_estimate;        // The alignment.
  ErrorStatistics absolute;
  RelativeErrors per_frame;  // From each pair to the next.
  RelativeErrors per_delta;
  DriftErrors drift;
};

struct Evaluation {
  EvaluationOptions options;
  std::vector<EvaluatedTrajectory> robots;
  std::optional<ErrorStatistics> all;  // Absolute, over the poses of all robots; if merged.
};

// Errors as CompareTrajectories.
absl::StatusOr<Evaluation> Evaluate(const std::vector<TrajectoryPair>& pairs,
                                    const EvaluationOptions& options = {});

// The errors of one pair: of the position in metres, of the orientation in degrees.
double PositionError(const PosePair& pair);
double RotationErrorDeg(const PosePair& pair);

}  // namespace isthmus::evaluation
