// The pairs that a server with many sessions searches, and those that searching all would find.
#pragma once

#include <absl/status/statusor.h>

#include <map>
#include <set>
#include <utility>
#include <vector>

#include "lab/bench/merging/driven_robot.h"
#include "server/pipeline_options.h"

namespace isthmus::bench {

using SessionPair = std::pair<SessionId, SessionId>;  // first < second.

struct SearchedPairs {
  // Looked at, those included that were worth no more; searched in full; accepted.
  std::set<SessionPair> looked_at, searched, accepted;
  std::map<SessionId, uint32_t> components;
  double cpu_s = 0;  // CPU time of the process until the server is idle.
};

// Has a server take up the sessions' stored submaps, and waits until it is done.
absl::StatusOr<SearchedPairs> SearchAsServer(const std::vector<DrivenRobot>& robots,
                                             const server::PipelineOptions& options);

// The pairs that are accepted, each searched by itself.
absl::StatusOr<std::set<SessionPair>> SearchAll(const std::vector<DrivenRobot>& robots,
                                                const std::set<SessionPair>& pairs,
                                                const server::PipelineOptions& options);

}  // namespace isthmus::bench
