// The match graph, and a person's word on it. What each returns and fails with is said in
// api/isthmus/v1/map_service.proto and match_service.proto.
#pragma once

#include <absl/status/statusor.h>

#include "isthmus/v1/map_service.pb.h"
#include "isthmus/v1/match_service.pb.h"
#include "server/pipeline.h"

namespace isthmus::rpc {

absl::StatusOr<v1::MatchGraph> GetMatchGraph(server::Pipeline& pipeline,
                                             const v1::GetMatchGraphRequest& request);
absl::StatusOr<v1::DecideMatchResponse> DecideMatch(server::Pipeline& pipeline,
                                                    const v1::DecideMatchRequest& request);

}  // namespace isthmus::rpc
