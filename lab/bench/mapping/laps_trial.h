// A trial of growth: laps over the same ground should not make a map larger and larger.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "lab/bench/mapping/lap_replay.h"
#include "server/pipeline_options.h"

namespace isthmus::bench {

// The map after so many laps.
struct LapsRow {
  int laps = 0;
  uint64_t submaps = 0, retired = 0;
  size_t loops = 0, edges = 0;                // Loop closures that are kept, and their edges.
  double database_mb = 0;                     // Files of the store.
  double resident_mb = 0;                     // RAM of the process, the recorded lap included.
  double ms_per_lap = 0, cpu_ms_per_lap = 0;  // Since the row before.
  double rmse_m = 0;                          // Error of the submaps in the map, rigidly aligned.
};

struct LapsTrial {
  size_t submaps_per_lap = 0;
  double lap_m = 0;  // From submap to submap and back to the first.
  std::vector<LapsRow> rows;
};

// `laps` laps through a server whose SQLite store is in a temporary folder; a row every `every`
// laps, given to `progress`, if there is one, at once. Noise is added and submaps are made apart
// from what is timed.
absl::StatusOr<LapsTrial> RunLaps(LapReplay replay, int laps, int every,
                                  const server::PipelineOptions& options,
                                  const std::function<void(const LapsRow&)>& progress = {});

}  // namespace isthmus::bench
