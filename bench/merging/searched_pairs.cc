#include "bench/merging/searched_pairs.h"

#include <string>

#include "bench/cpu_clock.h"
#include "bench/merging/trial.h"
#include "server/jobs/job_runner.h"
#include "server/pipeline.h"

namespace isthmus::bench {
namespace {

server::MapOfJob MapOf(const DrivenRobot& robot) {
  server::MapOfJob map;
  map.session = robot.session.id;
  for (const auto& submap : robot.submaps) {
    map.submaps.push_back(submap->id.index);
    map.stamps_ns.push_back(submap->first_stamp_ns);
    map.T_odom_submap.push_back(submap->T_odom_submap);
  }
  return map;
}

}  // namespace

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
  const MatchGraph graph = (*pipeline)->GetMatchGraph();
  for (const MatchEdge& edge : graph.matches) {
    const SessionPair pair(edge.match.a, edge.match.b);
    result.searched.insert(pair);
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
  std::map<SessionId, server::MapOfJob> maps;
  for (const DrivenRobot& robot : robots) maps.emplace(robot.session.id, MapOf(robot));
  server::JobRunner runner(store->get(), {});
  std::set<SessionPair> found;
  for (const SessionPair& pair : pairs) {
    server::PairJob job{.a = maps.at(pair.first), .b = maps.at(pair.second)};
    job.options = options.matcher;
    job.search = true;
    const auto match = runner.Run(job, {});
    if (!match.ok()) return match.status();
    if (match->state == MatchState::kAccepted) found.insert(pair);
  }
  return found;
}

}  // namespace isthmus::bench
