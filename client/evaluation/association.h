// Poses of two trajectories that belong together in time.
#pragma once

#include <cstdint>
#include <vector>

#include "core/map/trajectory.h"
#include "core/pose.h"

namespace isthmus::evaluation {

struct PosePair {
  int64_t stamp_ns = 0;  // The estimate's.
  Pose truth, estimate;
};

// Each estimated pose with the true one nearest in time, if that is within `tolerance_s`. A true
// pose is used once: of several estimates the nearest in time, of equally near ones the first, so
// that where rates differ nothing is compared with a truth that stood still. In order of time; the
// trajectories need not be.
std::vector<PosePair> Associate(const Trajectory& truth, const Trajectory& estimate,
                                double tolerance_s);

// The way along the true positions up to each pair, metres; 0 for the first.
std::vector<double> WayAlongTruth(const std::vector<PosePair>& pairs);

}  // namespace isthmus::evaluation
