#include "lab/bench/mapping/map_trial.h"

#include <absl/status/status.h>
#include <absl/strings/str_cat.h>

#include <algorithm>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "client/evaluation/picture.h"
#include "lab/bench/cpu_clock.h"
#include "lab/bench/mapping/map_truth.h"
#include "lab/bench/mapping/upload.h"
#include "lab/bench/merging/driven_robot.h"
#include "server/pipeline.h"
#include "storage/memory_store.h"

namespace isthmus::bench {
namespace {

constexpr size_t kOneIn = 4;     // Points that are drawn of those in submaps.
constexpr double kLowestM = -1;  // Below where the first sensor began: ground that is driven on.
constexpr size_t kChunk = 100'000;

evaluation::PictureOptions Style() {
  evaluation::PictureOptions options;
  options.min_z_m = kLowestM;
  return options;
}

std::vector<std::string> NamesOf(const std::vector<DrivenRobot>& robots) {
  std::vector<std::string> names;
  for (const DrivenRobot& robot : robots) names.push_back(robot.session.robot.value());
  return names;
}

absl::Status DrawOpen(const std::vector<DrivenRobot>& robots, const std::string& path) {
  std::vector<MapPoint> points;
  std::vector<Trajectory> ways;
  for (uint32_t r = 0; r < robots.size(); ++r) {
    ways.push_back(OdometryKeyframes(robots[r]));
    for (const auto& submap : robots[r].submaps) {
      for (size_t i = 0; i < submap->points.size(); i += kOneIn) {
        const Eigen::Vector3f p =
            (submap->T_odom_submap * submap->points[i].Position().cast<double>()).cast<float>();
        points.push_back({p.x(), p.y(), p.z(), submap->points[i].intensity, r});
      }
    }
  }
  return evaluation::WritePicture(path, points, ways, NamesOf(robots), Style());
}

absl::Status DrawClosed(const std::vector<DrivenRobot>& robots, server::Pipeline& pipeline,
                        const std::string& path) {
  std::vector<Trajectory> ways(robots.size());
  Region region;
  for (size_t r = 0; r < robots.size(); ++r) {
    auto trajectories =
        pipeline.reader().GetTrajectory(robots[r].session.robot, TrajectoryFrame::kMap);
    if (!trajectories.ok()) return trajectories.status();
    if (r == 0) region.component = trajectories->component;
    if (trajectories->component == region.component) ways[r] = std::move(trajectories->poses);
  }
  std::vector<MapPoint> points;
  const auto add = [&](const std::vector<MapPoint>& chunk) {
    points.insert(points.end(), chunk.begin(), chunk.end());
    return true;
  };
  if (absl::Status status = pipeline.reader().Map()->Read(region, kChunk, add); !status.ok()) {
    return status;
  }
  return evaluation::WritePicture(path, points, ways, NamesOf(robots), Style());
}

// Writes `path`_open.png, the submaps where odometry has them, the first robot's frame for all, and
// `path`_closed.png, the map of the first robot's component. Errors of writing files.
absl::Status DrawOpenAndClosed(const std::vector<DrivenRobot>& robots, server::Pipeline& pipeline,
                               const std::string& path) {
  absl::Status status = DrawOpen(robots, path + "_open.png");
  if (status.ok()) status = DrawClosed(robots, pipeline, path + "_closed.png");
  return status;
}

absl::Status MeasureMap(const std::vector<DrivenRobot>& robots, server::Pipeline& pipeline,
                        MapTrial* trial) {
  for (const DrivenRobot& robot : robots) {
    const auto open = OpenLoopRmse(robot);
    if (!open.ok()) return open.status();
    trial->open_m.push_back(*open);
    trial->submaps += robot.submaps.size();
  }
  auto map = MapRmse(robots, pipeline);
  auto trajectories = TrajectoryRmse(robots, pipeline);
  trial->one_frame = map.ok() && trajectories.ok();
  if (trial->one_frame) {
    trial->map = *std::move(map);
    trial->trajectories = *std::move(trajectories);
    trial->sharpness = MeasureSharpness(robots, pipeline);
  } else if (map.status().code() != absl::StatusCode::kFailedPrecondition) {
    return map.ok() ? trajectories.status() : map.status();
  }
  auto loops = pipeline.reader().ListLoops(std::nullopt);
  if (!loops.ok()) return loops.status();
  trial->loops = JudgeLoops(*loops, robots);
  trial->found = *std::move(loops);
  for (const MatchEdge& edge : pipeline.reader().GetMatchGraph().matches) {
    const Match& match = edge.match;
    trial->matches.push_back(absl::StrCat(match.a.value(), " ~ ", match.b.value(), ": ",
                                          ToString(match.state), ", ", ToString(match.reason), ": ",
                                          match.detail));
  }
  const MapInfo info = pipeline.GetMapInfo();
  trial->in_map = info.submaps;
  trial->retired = info.retired;
  trial->revisions = static_cast<uint64_t>(info.revision);
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<MapTrial> RunMapTrial(std::vector<DrivenRobot> robots,
                                     const MapTrialOptions& options) {
  const auto pipeline = server::Pipeline::Open(options.pipeline, storage::MakeMemoryStore());
  if (!pipeline.ok()) return pipeline.status();
  char letter = 'a';
  for (DrivenRobot& robot : robots) {
    absl::Status status =
        OpenSession(absl::StrCat("robot_", std::string(1, letter++)), **pipeline, &robot);
    if (!status.ok()) return status;
  }
  MapTrial trial;
  const CpuClock clock(CpuClock::Of::kProcess);
  absl::Status status = UploadAll(robots, **pipeline, &trial.worst_upload_ms);
  if (status.ok()) status = FinishAll(robots, **pipeline);
  trial.cpu_ms = clock.Ms();
  if (status.ok()) status = MeasureMap(robots, **pipeline, &trial);
  if (status.ok() && !options.picture.empty()) {
    status = DrawOpenAndClosed(robots, **pipeline, options.picture);
  }
  if (!status.ok()) return status;
  return trial;
}

}  // namespace isthmus::bench
