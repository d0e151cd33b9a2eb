#include "lab/bench/merging/update.h"

#include <absl/strings/str_format.h>

#include <algorithm>
#include <map>
#include <utility>

#include "core/stopwatch.h"
#include "lab/bench/merging/figures.h"
#include "lab/bench/merging/trial.h"
#include "server/pipeline.h"

namespace isthmus::bench {
namespace {

bool IsAccepted(server::Pipeline& pipeline, const SessionId& session) {
  const std::vector<MatchEdge> matches = pipeline.reader().GetMatchGraph().matches;
  return std::any_of(matches.begin(), matches.end(), [&](const MatchEdge& edge) {
    return edge.match.b == session && edge.match.state == MatchState::kAccepted;
  });
}

absl::Status Add(const DrivenRobot& robot, size_t from, size_t to, server::Pipeline& pipeline) {
  for (size_t i = from; i < to; ++i) {
    Submap submap = *robot.submaps[i];
    if (const auto added = pipeline.sessions().AddSubmap(std::move(submap)); !added.ok()) {
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
  const auto session = (*pipeline)->sessions().Create({last.session.robot, last.session.sensor});
  if (!session.ok()) return session.status();
  absl::Status status = Add(last, 0, count - kUpdates, **pipeline);
  if (!status.ok()) return status;
  UpdateTrial trial;
  trial.all_ms = (*pipeline)->GetMapInfo().estimation_ms;
  for (size_t i = count - kUpdates; i < count; ++i) {
    const uint64_t before = (*pipeline)->GetMapInfo().estimations;
    const bool accepted = IsAccepted(**pipeline, last.session.id);
    const Stopwatch watch;  // One submap may take several estimations.
    status = Add(last, i, i + 1, **pipeline);
    if (!status.ok()) return status;
    if ((*pipeline)->GetMapInfo().estimations == before) {
      return absl::InternalError("one submap more made no estimation");
    }
    (accepted ? trial.accepted_ms : trial.open_ms).push_back(watch.Ms());
  }
  return trial;
}

std::string UpdateTable(const std::vector<UpdateTrial>& trials) {
  std::map<std::string, UpdateTrial> by_scenario;
  std::map<std::string, std::vector<double>> all;
  for (const UpdateTrial& trial : trials) {
    UpdateTrial& sum = by_scenario[trial.scenario];
    all[trial.scenario].push_back(trial.all_ms);
    const auto append = [](const std::vector<double>& from, std::vector<double>* to) {
      to->insert(to->end(), from.begin(), from.end());
    };
    append(trial.accepted_ms, &sum.accepted_ms);
    append(trial.open_ms, &sum.open_ms);
  }
  std::string table =
      "| scenario | first estimation ms (worst) | one more submap, match accepted: times, ms "
      "(worst) "
      "| not yet: times, ms (worst) |\n|---|---|---|---|\n";
  for (const auto& [scenario, sum] : by_scenario) {
    const auto& first = all[scenario];
    absl::StrAppendFormat(&table, "| %s | %.0f (%.0f) | %d, %.0f (%.0f) | %d, %.0f (%.0f) |\n",
                          scenario, Median(first), Worst(first), sum.accepted_ms.size(),
                          Median(sum.accepted_ms), Worst(sum.accepted_ms), sum.open_ms.size(),
                          Median(sum.open_ms), Worst(sum.open_ms));
  }
  return table;
}

}  // namespace isthmus::bench
