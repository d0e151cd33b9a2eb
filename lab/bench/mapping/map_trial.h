// A trial of loop closure: robots with bad odometry, through the real server.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <string>
#include <vector>

#include "core/map/match.h"
#include "lab/bench/mapping/map_truth.h"
#include "lab/bench/merging/driven_robot.h"
#include "lab/bench/merging/odom_frames.h"
#include "lab/bench/merging/sharpness.h"
#include "server/pipeline_options.h"

namespace isthmus::bench {

struct MapTrial {
  std::string name;
  uint64_t seed = 0;
  size_t submaps = 0;                // Uploaded, of all robots.
  uint64_t in_map = 0, retired = 0;  // Number of these in the map, and of retired ones.
  std::vector<double> open_m;        // Each robot's RMSE by its odometry alone.
  TeamRmse map;                      // Error of the submaps in the map, and ...
  TeamRmse trajectories;             // ... of the ways; none if they are not in one component.
  bool one_frame = false;
  SharpnessFigures sharpness;  // The map's, where it is one.
  LoopFigures loops;
  std::vector<std::string> matches;  // Matches found between the robots, a line each.
  uint64_t revisions = 0;
  double cpu_ms = 0;           // The process's, all uploads to the settled map.
  double worst_upload_ms = 0;  // Wall time from a submap to the map settled with it.
  // The parts of the map, for placing it again.
  std::vector<Loop> found;
};

// Settings of a trial, beside its robots.
struct MapTrialOptions {
  server::PipelineOptions pipeline;
  std::string picture;  // Two are drawn, named so with _open.png and _closed.png; empty: none.
};

// Robots upload as they drove, at the same time if their stamps say so, and finish their sessions.
absl::StatusOr<MapTrial> RunMapTrial(std::vector<DrivenRobot> robots,
                                     const MapTrialOptions& options);

}  // namespace isthmus::bench
