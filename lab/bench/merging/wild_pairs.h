// Pairs of robots in wild worlds: who overlaps with whom, and who only seems to.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "lab/bench/merging/drive_cache.h"
#include "lab/bench/merging/drive_options.h"
#include "lab/bench/merging/driven_robot.h"
#include "lab/bench/merging/seen_surface.h"
#include "lab/bench/merging/trial.h"

namespace isthmus::bench {

struct WildPairsOptions {
  int worlds = 0;
  uint64_t seed = 1;        // The first world's; the others follow.
  std::string kind = {};    // See simulation::WildKinds: some with commas; empty: all; in turn.
  std::string sensor = {};  // Empty: one that is drawn.
  int robots = 4;           // In each world.
  double seconds = 60;      // Each drives.
  bool whole = false;       // Pairs are not cut back.
  bool one_day = false;     // All robots drive on the day on which the world was made.
  // Only pairs of strangers: every robot with each of the world of its kind among those from this
  // seed on.
  std::optional<uint64_t> strangers = {};
};

enum class WildRelation {
  kTeam,      // In one world, whatever they have in common.
  kStranger,  // In different worlds of one kind.
  kTwin,      // In worlds built alike, of which nothing loose is the same.
  kExactTwin,
  kBareTwin,  // The same to the last chair; the same walls without any furniture.
};

// Two drives to be merged, or not to be.
struct WildPair {
  WildRelation relation = WildRelation::kTeam;
  std::string kind;
  uint64_t seed = 0;  // Seed of the world, or of the first robot's.
  DriveOptions a, b;
  // Drives that overlap by more are cut back to so much, if that can be.
  double most_overlap = 1;
};

// All pairs of the worlds. The same options give the same pairs.
absl::StatusOr<std::vector<WildPair>> DrawWildPairs(const WildPairsOptions& options);

// The two robots, with all that they drove.
absl::StatusOr<std::vector<DrivenRobot>> WholeRobots(const WildPair& pair, DriveCache& cache);

// The scans of each that are kept where the pair is cut back; all where it is not.
std::pair<ScanRange, ScanRange> KeptScans(const WildPair& pair,
                                          const std::vector<DrivenRobot>& whole);

// The two robots, cut back.
absl::StatusOr<std::vector<DrivenRobot>> DriveWildPair(const WildPair& pair, DriveCache& cache);

// "house", "house stranger", "house twin", "flat exact twin": names of scenarios.
std::string NameOf(const WildPair& pair);

// Markdown: what became of pairs by what they have in common, and by kind.
std::string WildTable(const std::vector<Trial>& trials);

}  // namespace isthmus::bench
