// A recorded lap, driven again and again.
#pragma once

#include <absl/status/statusor.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "lab/bench/merging/driven_robot.h"
#include "lab/bench/merging/odom_frames.h"
#include "lab/simulation/random.h"

namespace isthmus::bench {

struct ReplayOptions {
  DriftOptions drift = {.percent = 0.5, .deg_per_m = 0.05};
  double noise_m = 0.01;  // Standard deviation along each axis, fresh for every point.
  size_t max_points = 0;  // Per submap, evenly thinned; 0: all.
  uint64_t seed = 1;
};

// Not thread safe. Deterministic.
class LapReplay {
 public:
  // The submaps from one near the drive's beginning to where a later one begins nearest to it,
  // after going away from it: once around. FailedPrecondition for a drive that does not come back.
  static absl::StatusOr<LapReplay> Create(const DrivenRobot& robot, const ReplayOptions& options);

  size_t submaps() const { return lap_.size(); }
  // The next of the laps, with ids and stamps that go on from the one before. Odometry is the
  // recorded one with drift, from the last of a lap to the first of the next as in truth.
  Submap Next();
  // The true pose of the submap with that index, in whichever lap.
  const Pose& TruePose(uint32_t index) const { return truth_[index % truth_.size()]; }

 private:
  LapReplay(const DrivenRobot& robot, size_t begin, size_t end, const ReplayOptions& options);
  Pose Step(size_t from) const;

  ReplayOptions options_;
  simulation::Random random_;
  std::vector<std::shared_ptr<const Submap>> lap_;
  std::vector<Pose> truth_;  // T_world_submap.
  int64_t lap_ns_ = 0;
  uint32_t next_ = 0;
  Pose T_odom_next_;
};

}  // namespace isthmus::bench
