// Wild drives for the odometry, simulated anew or as they were kept on disk.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <string>

#include "lab/bench/drive.h"
#include "lab/simulation/wild/wild.h"

namespace isthmus::bench {

struct WildRide {
  std::string kind, carrier, about;
  uint64_t seed = 0;
  Drive drive;
};

// The drive of a seed. With a `cache`, a folder that is made if need be, it is taken from there;
// what is not there is simulated whole and left there: one file a drive, named after kind, seed,
// sensor, seconds and simulation::kWildVersion. Several programs may use one folder. Without,
// scans are simulated when they are asked for. Errors as simulation::DrawWildDrive, and of files.
absl::StatusOr<WildRide> GetWildRide(uint64_t seed, const simulation::WildOptions& options,
                                     const std::string& cache);

}  // namespace isthmus::bench
