// One trial of merging: robots' maps, and the transforms the server finds between them.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "core/map/match.h"
#include "lab/bench/merging/driven_robot.h"
#include "lab/bench/merging/judge.h"
#include "lab/bench/merging/sharpness.h"
#include "server/pipeline_options.h"
#include "storage/map_store.h"

namespace isthmus::bench {

enum class TrialOutcome {
  // Merged, and the maps lie within 0.3 m and 1 degree, drift apart; where drift has bent them by
  // more than that, it is enough that the edges do.
  kRight,
  kNotMerged,  // Not yet, ambiguous or rejected: Match::state and reason say which.
  kWrong,      // Merged otherwise.
};

// Two robots of a trial.
struct PairResult {
  int a = 0, b = 0;
  double overlap = 0;  // Share of the surface of the robot that saw less which the other saw too.
  Match match;         // The best hypothesis, accepted or not.
  TrialOutcome outcome = TrialOutcome::kNotMerged;
  // Errors of the match, whatever its state; meaningless if the robots were in different worlds.
  MapError map, start;
  MapError drift;  // Within the part both have seen; see PairTruth::drift.
  MapError edges;  // Errors of the match's edges between submaps.
  bool hypothesis_right =
      false;  // The maps lie within 0.5 m and 2 degrees, drift apart, whatever the state.
  std::vector<bool> rivals_right;  // The same of the match's rivals.
  // Both are in one frame, and lie in it more than 1 m or 3 degrees off, drift apart.
  bool frame_wrong = false;

  bool HasHypothesis() const { return match.candidates > 0; }
};

// A robot's positions against the truth, RMSE.
struct RobotRmse {
  double odometry_m = 0;  // By itself, in an alignment of its own.
  double bent_m = 0;      // As the map has its trajectory, in an alignment of its own.
  double joined_m = 0;    // The same in the alignment of all robots of the frame.

  // Metres by which joining made it worse than a merged map may be; below zero: it did not.
  double Beyond() const { return Excess(joined_m); }
  double BentBeyond() const { return Excess(bent_m); }

 private:
  double Excess(double merged_m) const { return merged_m - (1.5 * odometry_m + 0.01); }
};

struct Trial {
  std::string scenario;
  std::string world;  // The first robot's.
  uint64_t seed = 0;
  std::vector<PairResult> pairs;
  size_t submaps = 0;  // Sum over all robots.
  size_t loops = 0;    // Sum over all robots, found before.
  int lost_scans = 0;
  double odometry_m = 0;  // RMSE of the worst robot in its own frame.
  // From stored submaps to decided matches: wall time of the estimation, and CPU time of the
  // process, in which composing the map is contained.
  double estimation_ms = 0, cpu_ms = 0;
  std::vector<uint32_t> frames;  // The component of each robot.
  bool one_frame = false;        // All robots are in one component.
  double team_rmse_m = -1;     // Positions of all robots in that frame, after one rigid alignment.
  SharpnessFigures sharpness;  // Their map's; nothing where they are not in one.
  std::vector<RobotRmse> robots;  // The robots in that frame.
  std::vector<RobotRmse> joined;  // All robots that have company, without joined_m.
};

struct TrialOptions {
  // A person accepts what was found of each pair where it is right and waits.
  bool accept_right = false;
  // The robots' submaps come one by one and in turn, and the server is idle before the next comes.
  // Otherwise all are there when it starts.
  bool grow = false;
};

// Has a server take up the robots' submaps, waits until it is done, and judges by the truth.
// `robots` are two or more. Scenario and seed are left to the caller.
absl::StatusOr<Trial> RunTrial(std::vector<DrivenRobot> robots,
                               const server::PipelineOptions& options, const TrialOptions& how);

// A store in memory that holds the robots' sessions with their submaps and loops.
absl::StatusOr<std::unique_ptr<storage::MapStore>> StoreOf(const std::vector<DrivenRobot>& robots);

// Calls the robots robot_a, robot_b, ... in order.
void NameInOrder(std::vector<DrivenRobot>* robots);

}  // namespace isthmus::bench
