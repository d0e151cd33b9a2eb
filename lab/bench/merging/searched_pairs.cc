#include "lab/bench/merging/searched_pairs.h"

#include "lab/bench/cpu_clock.h"
#include "lab/bench/merging/trial.h"
#include "server/jobs/job_runner.h"
#include "server/pipeline.h"

namespace isthmus::bench {

absl::StatusOr<SearchedPairs> SearchAsServer(const std::vector<DrivenRobot>& robots,
                                             const server::PipelineOptions& options) {
  auto store = StoreOf(robots);
  if (!store.ok()) return store.status();
  const CpuClock clock(CpuClock::Of::kProcess);
  const auto pipeline = server::Pipeline::Open(options, *std::move(store));
  if (!pipeline.ok()) return pipeline.status();
  (*pipeline)->WaitUntilIdle();
  SearchedPairs result;
  result.cpu_s = 1e-3 * clock.Ms();
  const MatchGraph graph = (*pipeline)->reader().GetMatchGraph();
  for (const MatchEdge& edge : graph.matches) {
    const SessionPair pair(edge.match.a, edge.match.b);
    result.looked_at.insert(pair);
    if (edge.match.reason != MatchReason::kNoCandidate) result.searched.insert(pair);
    if (edge.match.state == MatchState::kAccepted) result.accepted.insert(pair);
  }
  for (const PlacedSession& placed : graph.placements) {
    result.components[placed.placement.session] = placed.placement.component;
  }
  return result;
}

absl::StatusOr<std::set<SessionPair>> SearchAll(const std::vector<DrivenRobot>& robots,
                                                const std::set<SessionPair>& pairs,
                                                const server::PipelineOptions& options) {
  auto store = StoreOf(robots);
  if (!store.ok()) return store.status();
  std::map<SessionId, server::JobMapInput> maps;
  for (const DrivenRobot& robot : robots) {
    const SessionId& id = robot.session.id;
    maps.emplace(id, server::MakeJobMapInput(id, robot.submaps));
  }
  server::JobRunner runner(store->get(), {});
  std::set<SessionPair> found;
  for (const SessionPair& pair : pairs) {
    server::PairJob job{.a = maps.at(pair.first), .b = maps.at(pair.second)};
    job.options = options.matcher;
    job.search = true;
    const auto result = runner.Run(job, {});
    if (!result.ok()) return result.status();
    if (result->match.state == MatchState::kAccepted) found.insert(pair);
  }
  return found;
}

}  // namespace isthmus::bench
