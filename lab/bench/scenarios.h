// The scenarios that odometry is measured on.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "lab/bench/drive.h"

namespace isthmus::bench {

struct ScenarioOptions {
  std::string sensor = "vlp16";  // Simulated; see simulation::MakeLidar.
  double seconds = 0;            // Length of the drive; 0: what the scenario is meant to have.
};

struct Scenario {
  std::string name;
  std::string what;             // One line for people.
  std::vector<uint64_t> seeds;  // Unless others are asked for.
  std::function<absl::StatusOr<Drive>(const ScenarioOptions& options, uint64_t seed)> make;
};

// All that are simulated.
const std::vector<Scenario>& Scenarios();

// The scenarios whose name is or begins with one of `names`; all if there are none.
// InvalidArgument, listing the names, if one of them fits nothing.
absl::StatusOr<std::vector<Scenario>> FindScenarios(const std::vector<std::string>& names);

// A recorded drive: a folder of KITTI's .bin (times.txt in it or beside it gives the stamps) and
// its reference poses, KITTI rows of the LiDAR, one per scan. Errors as readers::OpenRecording;
// InvalidArgument if there are fewer poses than scans.
absl::StatusOr<Drive> RecordedDrive(const std::string& folder, const std::string& poses);

}  // namespace isthmus::bench
