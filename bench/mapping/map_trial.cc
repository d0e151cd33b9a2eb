#include "bench/mapping/map_trial.h"

#include <absl/strings/str_cat.h>

#include <algorithm>
#include <memory>
#include <utility>

#include "bench/cpu_clock.h"
#include "bench/mapping/map_picture.h"
#include "bench/mapping/upload.h"
#include "server/pipeline.h"
#include "storage/memory_store.h"

namespace isthmus::bench {
namespace {

absl::Status Judge(const std::vector<DrivenRobot>& robots, server::Pipeline& pipeline,
                   MapTrial* trial) {
  for (const DrivenRobot& robot : robots) {
    const auto open = OpenLoopRmse(robot);
    if (!open.ok()) return open.status();
    trial->open_m.push_back(*open);
    trial->submaps += robot.submaps.size();
  }
  auto map = MapRmse(robots, pipeline);
  auto way = WayRmse(robots, pipeline);
  trial->one_frame = map.ok() && way.ok();
  if (trial->one_frame) {
    trial->map = *std::move(map);
    trial->way = *std::move(way);
  } else if (map.status().code() != absl::StatusCode::kFailedPrecondition) {
    return map.ok() ? way.status() : map.status();
  }
  auto loops = pipeline.ListLoops(std::nullopt);
  if (!loops.ok()) return loops.status();
  trial->loops = JudgeLoops(*loops, robots);
  trial->found = *std::move(loops);
  for (const MatchEdge& edge : pipeline.GetMatchGraph().matches) {
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
  if (status.ok()) status = Judge(robots, **pipeline, &trial);
  if (status.ok() && !options.picture.empty()) {
    status = DrawOpenAndClosed(robots, **pipeline, options.picture);
  }
  if (!status.ok()) return status;
  return trial;
}

}  // namespace isthmus::bench
