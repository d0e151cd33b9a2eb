#include "lab/bench/mapping/upload.h"

#include <algorithm>
#include <memory>
#include <utility>

#include "core/stopwatch.h"

namespace isthmus::bench {

absl::Status OpenSession(const std::string& name, server::Pipeline& pipeline, DrivenRobot* robot) {
  const auto session = pipeline.sessions().Create({RobotId(name), robot->session.sensor});
  if (!session.ok()) return session.status();
  Rename(robot, name);
  robot->session.id = session->record.id;
  for (auto& submap : robot->submaps) {
    auto named = std::make_shared<Submap>(*submap);
    named->id.session = session->record.id;
    submap = std::move(named);
  }
  return absl::OkStatus();
}

absl::Status Upload(const Submap& submap, server::Pipeline& pipeline) {
  const auto added = pipeline.sessions().AddSubmap(submap);
  if (added.ok()) pipeline.WaitUntilIdle();
  return added.status();
}

absl::Status UploadAll(const std::vector<DrivenRobot>& robots, server::Pipeline& pipeline,
                       double* worst_ms) {
  std::vector<const Submap*> in_order;
  for (const DrivenRobot& robot : robots) {
    for (const auto& submap : robot.submaps) in_order.push_back(submap.get());
  }
  std::stable_sort(in_order.begin(), in_order.end(), [](const Submap* a, const Submap* b) {
    return a->last_stamp_ns < b->last_stamp_ns;
  });
  for (const Submap* submap : in_order) {
    const Stopwatch stopwatch;
    if (absl::Status status = Upload(*submap, pipeline); !status.ok()) return status;
    if (worst_ms != nullptr) *worst_ms = std::max(*worst_ms, stopwatch.Ms());
  }
  return absl::OkStatus();
}

absl::Status FinishAll(const std::vector<DrivenRobot>& robots, server::Pipeline& pipeline) {
  for (const DrivenRobot& robot : robots) {
    absl::Status status = pipeline.sessions().Finish(robot.session.id).status();
    if (!status.ok()) return status;
  }
  pipeline.WaitUntilIdle();
  return absl::OkStatus();
}

}  // namespace isthmus::bench
