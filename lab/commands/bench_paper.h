// The comparison of the paper's Tables 3 to 5: the same server with one odometry or another.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "client/evaluation/trajectory_error.h"
#include "core/map/match.h"

namespace isthmus::cli {

struct PaperBenchOptions {
  std::vector<std::string> worlds = {"museum", "campus"};
  std::vector<std::string> modes = {"aloam", "floam", "continuous"};  // The odometry's.
  std::vector<uint64_t> seeds = {1};
  double seconds = 90;  // Length of each drive.
};

struct PaperBenchRobot {
  std::string name;
  double travelled_m = 0;
  uint64_t scans = 0, lost = 0;    // Processed; lost among them.
  double mean_ms = 0, max_ms = 0;  // Odometry per scan, wall time, decoding apart.
  // Parts of mean_ms, on average.
  double features_ms = 0, matching_ms = 0, map_ms = 0;
  evaluation::ErrorStatistics own;     // In its odom frame, aligned by itself.
  evaluation::ErrorStatistics in_map;  // In the merged map, aligned together; if merged.
};

// Two robots of one world and seed through a server of their own.
struct PaperBenchRun {
  std::string world, mode;
  uint64_t seed = 0;
  std::vector<PaperBenchRobot> robots;
  std::optional<evaluation::ErrorStatistics> all;  // In one frame; absent if not merged.
  double estimation_ms = 0;       // Time for the transform between the two: all stages of matching.
  std::vector<StageTime> stages;  // Parts of estimation_ms by name; equal names are added up.
  double composition_ms = 0;      // The last ...
  double composition_max_ms = 0;  // ... and the longest composition of the global map.
};

// Called before every scan with how many of the run's are done and how many there will be.
using BenchProgress = std::function<void(int done, int total)>;

// Scans are simulated while nothing is measured: the odometry of one is waited for before the next
// is made, and one robot drives after the other. InvalidArgument for a world or mode that does not
// exist.
absl::StatusOr<PaperBenchRun> RunPaperBench(const std::string& world, const std::string& mode,
                                            uint64_t seed, double seconds,
                                            const BenchProgress& progress);

}  // namespace isthmus::cli
