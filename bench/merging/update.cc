#include "bench/merging/update.h"

#include <absl/strings/str_format.h>

#include <map>
#include <utility>

#include "bench/merging/figures.h"
#include "bench/merging/trial.h"
#include "server/pipeline.h"

namespace isthmus::bench {
namespace {

absl::Status Add(const DrivenRobot& robot, size_t from, size_t to, server::Pipeline& pipeline) {
  for (size_t i = from; i < to; ++i) {
    Submap submap = *robot.submaps[i];
    if (const auto added = pipeline.AddSubmap(std::move(submap)); !added.ok()) {
      return added.status();
    }
  }
  pipeline.WaitUntilIdle();
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<UpdateTrial> RunUpdates(std::vector<DrivenRobot> robots,
                                       const server::PipelineOptions& options) {
  NameInOrder(&robots);
  const DrivenRobot last = std::move(robots.back());
  robots.pop_back();
  const size_t count = last.submaps.size();
  if (count <= kUpdates) return absl::FailedPreconditionError("too few submaps to add some later");
  auto store = StoreOf(robots);
  if (!store.ok()) return store.status();
  server::PipelineOptions eager = options;
  eager.rematch_submaps = 1;
  const auto pipeline = server::Pipeline::Open(eager, *std::move(store));
  if (!pipeline.ok()) return pipeline.status();
  const auto session = (*pipeline)->CreateSession({last.session.robot, last.session.sensor});
  if (!session.ok()) return session.status();
  absl::Status status = Add(last, 0, count - kUpdates, **pipeline);
  if (!status.ok()) return status;
  UpdateTrial trial;
  trial.all_ms = (*pipeline)->GetMapInfo().estimation_ms;
  for (size_t i = count - kUpdates; i < count; ++i) {
    const uint64_t before = (*pipeline)->GetMapInfo().estimations;
    status = Add(last, i, i + 1, **pipeline);
    if (!status.ok()) return status;
    const server::MapInfo info = (*pipeline)->GetMapInfo();
    if (info.estimations != before + 1) {
      return absl::InternalError("one submap more did not make one estimation more");
    }
    trial.ms.push_back(info.estimation_ms);
  }
  return trial;
}

std::string UpdateTable(const std::vector<UpdateTrial>& trials) {
  std::map<std::string, std::pair<std::vector<double>, std::vector<double>>> by_scenario;
  for (const UpdateTrial& trial : trials) {
    auto& [all, updates] = by_scenario[trial.scenario];
    all.push_back(trial.all_ms);
    updates.insert(updates.end(), trial.ms.begin(), trial.ms.end());
  }
  std::string table =
      "| scenario | first estimation ms (worst) | updates | after one more submap ms (worst) |\n"
      "|---|---|---|---|\n";
  for (const auto& [scenario, ms] : by_scenario) {
    const auto& [all, updates] = ms;
    absl::StrAppendFormat(&table, "| %s | %.0f (%.0f) | %d | %.0f (%.0f) |\n", scenario,
                          Median(all), Worst(all), updates.size(), Median(updates), Worst(updates));
  }
  return table;
}

}  // namespace isthmus::bench
