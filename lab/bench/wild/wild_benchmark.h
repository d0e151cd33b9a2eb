// Many wild drives, one after the other or several at a time.
#pragma once

#include <absl/status/status.h>

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "floam/odometry_options.h"
#include "lab/bench/wild/wild_drive.h"
#include "lab/bench/wild/wild_judge.h"

namespace isthmus::bench {

struct WildBenchmarkOptions {
  int drives = 0;
  std::optional<uint64_t> seed;  // The first drive's, the others follow; absent: never the same.
  simulation::WildOptions drawn;
  std::string cache;  // See GetWildRide.
  int every = 1;      // See KeepEvery.
  int jobs = 1;       // Drives at a time; costs are honest with 1.
};

// A drive that was run.
struct WildEntry {
  std::string kind, carrier, about, sensor;
  uint64_t seed = 0;
  double cal_ms = 0;  // See CalibrationMs.
  WildScore score;
};

// Prints a line about each drive when it is done. Errors as GetWildRide and Run.
absl::StatusOr<std::vector<WildEntry>> RunWildDrives(const WildBenchmarkOptions& options,
                                                     const floam::OdometryOptions& odometry);

std::string ToLine(const WildEntry& entry);
// Tables by kind and of all, and the worst drives.
std::string ToMarkdown(const std::vector<WildEntry>& entries);
nlohmann::ordered_json ToJson(const WildEntry& entry);

}  // namespace isthmus::bench
