// A pair that waits, in closed loop: a robot drives as the server asks it to, the match is judged
// again; and what the same metres bring where it drives on by itself.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "core/map/match.h"
#include "lab/bench/merging/drive_cache.h"
#include "lab/bench/merging/driven_robot.h"
#include "lab/bench/merging/wild_pairs.h"
#include "server/pipeline_options.h"

namespace isthmus::bench {

enum class AskedOutcome {
  kRight,    // Merged; see TrialOutcome.
  kWrong,    // Merged otherwise.
  kRefuted,  // Not merged; the best hypothesis was wrong before any drive, and is another place
             // now.
  kWaiting,
  kLost,  // The odometry began anew on the way.
};

// A match after some drives.
struct AskedState {
  AskedOutcome outcome = AskedOutcome::kWaiting;
  MatchState state = MatchState::kNotYet;
  MatchReason reason = MatchReason::kNone;
  double confidence = 0;
  bool hypothesis_right = false;
};

// A drive that was asked for.
struct AskedStep {
  int robot = 0;                // 0 or 1 of the pair.
  double asked_m = 0;           // AskedDrive::length_m, and
  double metres = 0;            // as driven.
  bool blocked = false;         // It ended before something solid.
  double predicted = 0;         // AskedDrive::confidence, if
  bool right = false;           // the hypothesis in question is right.
  AskedState asked, wandering;  // After it, and after as many metres of every robot by itself.
};

struct AskedTrial {
  std::string scenario;
  uint64_t seed = 0;
  int a = 0, b = 0;
  double overlap = 0;  // By the truth, before any drive.
  AskedState before;
  std::vector<AskedStep> steps;  // None where it does not wait, or nothing is asked.

  // It waits, and both have seen so much of the same that it should not.
  bool Waits() const;
};

// Drives in a row, each asked for anew.
inline constexpr int kAskedDrives = 3;

// The drives that are asked for; of a match between robots that are 0 and 1 there.
using Asker = std::function<std::vector<AskedDrive>(const Match&, const std::vector<DrivenRobot>&)>;

// `seed` moves the second robot's odom frame. Internal if what a drive begins with is not what was
// driven before.
absl::StatusOr<AskedTrial> RunAskedTrial(
    const WildPair& pair, uint64_t seed, const server::PipelineOptions& options, DriveCache& cache,
    const Asker& asker = [](const Match& match, const auto&) { return match.asked; });

}  // namespace isthmus::bench
