#include "lab/bench/mapping/undo_trial.h"

#include <algorithm>
#include <memory>
#include <numbers>
#include <optional>
#include <utility>

#include "lab/bench/mapping/upload.h"
#include "server/pipeline.h"
#include "storage/memory_store.h"

namespace isthmus::bench {
namespace {

constexpr char kA[] = "robot_a", kB[] = "robot_b";

// Both robots' ways in the map, one after the other.
absl::StatusOr<std::vector<Pose>> TrajectoriesInMap(server::Pipeline& pipeline) {
  std::vector<Pose> poses;
  for (const char* robot : {kA, kB}) {
    const auto trajectory = pipeline.reader().GetTrajectory(RobotId(robot), TrajectoryFrame::kMap);
    if (!trajectory.ok()) return trajectory.status();
    for (const StampedPose& pose : trajectory->poses) poses.push_back(pose.pose);
  }
  return poses;
}

struct Difference {
  double metres = 0, degrees = 0;
};

Difference Largest(const std::vector<Pose>& before, const std::vector<Pose>& after) {
  Difference largest;
  for (size_t i = 0; i < std::min(before.size(), after.size()); ++i) {
    const Pose moved = before[i].Inverse() * after[i];
    largest.metres = std::max(largest.metres, moved.translation().norm());
    largest.degrees = std::max(largest.degrees, RotationAngle(moved) * 180 / std::numbers::pi);
  }
  return largest;
}

MatchDecision Decision() { return {.robot_a = RobotId(kA), .robot_b = RobotId(kB)}; }

// The revision that came of the forced match: the oldest after `before` that names it.
absl::StatusOr<int64_t> RevisionOfMatch(int64_t before, server::Pipeline& pipeline) {
  const auto revisions = pipeline.reader().ListRevisions(1000);
  if (!revisions.ok()) return revisions.status();
  int64_t found = 0;
  for (const RevisionInfo& revision : *revisions) {
    if (revision.revision > before && !revision.matches.empty()) found = revision.revision;
  }
  if (found == 0) return absl::FailedPreconditionError("no revision came of the forced match");
  return found;
}

absl::Status Force(server::Pipeline& pipeline, bool* merged_before) {
  const auto matches = pipeline.reader().GetMatchGraph().matches;
  if (matches.size() != 1) return absl::InternalError("the pair has not been looked at");
  *merged_before = matches[0].match.state == MatchState::kAccepted;
  constexpr double kTurn = 20 * std::numbers::pi / 180;
  MatchDecision wrong = Decision();
  wrong.kind = ManualDecisionKind::kSet;
  wrong.T_a_b = Pose::FromXyzRpy(4, 3, 0, 0, 0, kTurn) * matches[0].match.T_a_b;
  wrong.note = "wrong on purpose";
  const auto decided = pipeline.decisions().DecideMatch(wrong);
  if (decided.ok()) pipeline.WaitUntilIdle();
  return decided.status();
}

absl::Status Undo(UndoBy how, int64_t before, server::Pipeline& pipeline) {
  absl::Status status;
  if (how == UndoBy::kWithdrawing) {
    status = pipeline.decisions().DecideMatch(Decision()).status();
  } else {
    const auto revision = RevisionOfMatch(before, pipeline);
    if (!revision.ok()) return revision.status();
    status = pipeline.decisions().UndoRevision(*revision, "undone").status();
  }
  if (status.ok()) pipeline.WaitUntilIdle();
  return status;
}

}  // namespace

absl::StatusOr<UndoTrial> RunUndo(std::vector<DrivenRobot> robots, UndoBy how,
                                  const server::PipelineOptions& options) {
  const auto pipeline = server::Pipeline::Open(options, storage::MakeMemoryStore());
  if (!pipeline.ok()) return pipeline.status();
  absl::Status status = OpenSession(kA, **pipeline, &robots.at(0));
  if (status.ok()) status = OpenSession(kB, **pipeline, &robots.at(1));
  if (status.ok()) status = UploadAll(robots, **pipeline);
  if (!status.ok()) return status;
  const auto before = TrajectoriesInMap(**pipeline);
  if (!before.ok()) return before.status();
  const int64_t revision = (*pipeline)->GetMapInfo().revision;
  UndoTrial trial;
  status = Force(**pipeline, &trial.merged_before);
  if (!status.ok()) return status;
  const auto forced = TrajectoriesInMap(**pipeline);
  if (!forced.ok()) return forced.status();
  trial.forced_m = Largest(*before, *forced).metres;
  if (trial.forced_m < 1) return absl::FailedPreconditionError("the forced match moved nothing");
  status = Undo(how, revision, **pipeline);
  if (!status.ok()) return status;
  const auto after = TrajectoriesInMap(**pipeline);
  if (!after.ok()) return after.status();
  if (after->size() != before->size()) return absl::InternalError("trajectories got other poses");
  const Difference left = Largest(*before, *after);
  trial.left_m = left.metres;
  trial.left_deg = left.degrees;
  return trial;
}

}  // namespace isthmus::bench
