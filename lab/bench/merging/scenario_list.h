// The scenarios of the merging benchmark: which robots' maps are merged.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "lab/bench/merging/drive_options.h"
#include "lab/bench/merging/odom_frames.h"
#include "lab/bench/merging/seen_surface.h"

namespace isthmus::bench {

struct MergingScenario {
  std::string name;
  std::vector<DriveOptions> robots;  // Seeds are added to the trial's.
  DriftOptions drift = {};
  // Only so much of the drives is taken that robots have seen so much of the same (as much as can
  // be; a trial is left out where there is no such part); absent: all.
  std::optional<OverlapRange> overlap = {};
};

const std::vector<MergingScenario>& MergingScenarios();

// The scenarios of these names, all if there are none. InvalidArgument for an unknown name.
absl::StatusOr<std::vector<MergingScenario>> FindMergingScenarios(
    const std::vector<std::string>& names);

}  // namespace isthmus::bench
