// All robots of a wild world at once: how many of those that overlap come into one frame.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <string>
#include <vector>

#include "lab/bench/merging/drive_cache.h"
#include "lab/bench/merging/drive_options.h"
#include "lab/bench/merging/driven_robot.h"
#include "lab/bench/merging/trial.h"
#include "lab/bench/merging/wild_pairs.h"

namespace isthmus::bench {

// The robots of one world.
struct WildTeam {
  std::string kind;
  uint64_t seed = 0;
  std::vector<DriveOptions> drives;
};

// The same drives as those of DrawWildPairs, whole.
absl::StatusOr<std::vector<WildTeam>> DrawWildTeams(const WildPairsOptions& options);

// The robots that were not lost all the way.
std::vector<DrivenRobot> DriveWildTeam(const WildTeam& team, DriveCache& cache);

// Markdown, a row per kind of world and one of all: in how many worlds all robots that hang
// together by true overlaps (0.3 and more, 0.15 and more) are in one frame, and what is wrong.
std::string WildTeamsTable(const std::vector<Trial>& trials);

}  // namespace isthmus::bench
