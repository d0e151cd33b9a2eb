// A simulation as files.
#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include <functional>
#include <string>
#include <vector>

#include "lab/simulation/simulator.h"

namespace isthmus::simulation {

// A summary of what was written, as in simulation.json.
struct RecordingSummary {
  int robots = 0;
  int scans_per_robot = 0;
  // Row i, column j: share of the surface that robots i and j have both measured, of the one that
  // measured less; see SeenSurface.
  std::vector<std::vector<double>> overlap;
};

// Called before every scan with how many are done and how many there will be.
using Progress = std::function<void(int done, int total)>;

// Makes all scans of all robots and writes to the folder `dir`, which is made if need be:
//   robot_0/000000.pcd ...   binary PCD: x y z intensity ring time, in order of firing
//   robot_0/times.txt        the END of each scan, seconds since the Unix epoch, nine decimals
//   robot_0.truth.tum        T_world_sensor at the END of each scan, by the stamps of times.txt
//   moved.truth.json         only on later days: boxes of what came and went since the first
//   simulation.json          the options, the scans per robot and how much the robots overlap
// Memory does not grow with the number of scans. Errors of the options as Simulator::Create;
// NotFound, PermissionDenied or ResourceExhausted (disk full) when writing fails.
absl::StatusOr<RecordingSummary> Record(const Options& options, const std::string& dir,
                                        const Progress& progress = {});

// The same for a given simulator.
absl::StatusOr<RecordingSummary> Record(const Simulator& simulator, const std::string& dir,
                                        const Progress& progress = {});

}  // namespace isthmus::simulation
