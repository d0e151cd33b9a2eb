#include "lab/bench/mapping/next_day_trial.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>
#include <vector>

#include "client/evaluation/trajectory_error.h"
#include "lab/bench/mapping/map_truth.h"
#include "lab/bench/mapping/upload.h"
#include "lab/bench/merging/temporary_folder.h"
#include "server/pipeline.h"
#include "storage/sqlite/sqlite_store.h"

namespace isthmus::bench {
namespace {

const RobotId kRobot("alice");

absl::StatusOr<std::unique_ptr<server::Pipeline>> OpenAt(const std::string& folder,
                                                         const server::PipelineOptions& options) {
  auto store = storage::OpenSqliteStore(folder, {.sync_every_commit = false});
  if (!store.ok()) return store.status();
  return server::Pipeline::Open(options, *std::move(store));
}

bool SamePlaces(const SubmapPlaces& a, const SubmapPlaces& b) {
  return a.size() == b.size() && std::all_of(a.begin(), a.end(), [&](const auto& entry) {
           const auto it = b.find(entry.first);
           if (it == b.end()) return false;
           const Pose moved = entry.second.T_map_submap.Inverse() * it->second.T_map_submap;
           return moved.translation().norm() < 1e-6 && RotationAngle(moved) < 1e-6;
         });
}

evaluation::TrajectoryPair InMap(const DrivenRobot& robot, const SubmapPlaces& places) {
  return {robot.session.id.value(), TrueKeyframes(robot), PlacedKeyframes(robot, places)};
}

absl::Status JudgeDays(const DrivenRobot& yesterday, const DrivenRobot& today,
                       const SubmapPlaces& places, NextDayTrial* trial) {
  const auto before = evaluation::CompareTrajectories({InMap(yesterday, places)});
  if (!before.ok()) return before.status();
  trial->yesterday_rmse_m = before->all.rmse_m;
  if (!trial->placed) return absl::OkStatus();
  evaluation::TrajectoryPair pair = InMap(today, places);
  for (StampedPose& pose : pair.estimate) pose.pose = before->T_truth_estimate * pose.pose;
  const auto now = evaluation::CompareTrajectories({pair}, evaluation::Alignment::kNone);
  if (!now.ok()) return now.status();
  trial->today_rmse_m = now->all.rmse_m;
  trial->today_worst_m = now->all.max_m;
  return absl::OkStatus();
}

bool InOneFrame(const DrivenRobot& yesterday, const DrivenRobot& today,
                const SubmapPlaces& places) {
  const auto a = places.find(yesterday.submaps.front()->id);
  const auto b = places.find(today.submaps.front()->id);
  return a != places.end() && b != places.end() && a->second.component == b->second.component;
}

}  // namespace

absl::StatusOr<NextDayTrial> RunNextDay(DrivenRobot yesterday, DrivenRobot today,
                                        const server::PipelineOptions& options) {
  const TemporaryFolder folder;
  NextDayTrial trial;
  SubmapPlaces places;
  {
    const auto pipeline = OpenAt(folder.path(), options);
    if (!pipeline.ok()) return pipeline.status();
    absl::Status status = OpenSession(kRobot.value(), **pipeline, &yesterday);
    if (status.ok()) status = UploadAll({yesterday}, **pipeline);
    if (status.ok()) status = (*pipeline)->sessions().Finish(yesterday.session.id).status();
    if (!status.ok()) return status;
    (*pipeline)->WaitUntilIdle();
    places = PlacesOf(**pipeline);
  }
  const auto pipeline = OpenAt(folder.path(), options);
  if (!pipeline.ok()) return pipeline.status();
  (*pipeline)->WaitUntilIdle();
  trial.same_after_restart = !places.empty() && SamePlaces(places, PlacesOf(**pipeline));
  absl::Status status = OpenSession(kRobot.value(), **pipeline, &today);
  trial.submaps = today.submaps.size();
  for (size_t i = 0; i < today.submaps.size() && status.ok(); ++i) {
    status = Upload(*today.submaps[i], **pipeline);
    places = PlacesOf(**pipeline);
    const bool placed = InOneFrame(yesterday, today, places);
    if (placed && !trial.placed) trial.placed_after = i + 1;
    trial.placed = placed;
  }
  if (status.ok()) status = JudgeDays(yesterday, today, places, &trial);
  if (!status.ok()) return status;
  return trial;
}

}  // namespace isthmus::bench
