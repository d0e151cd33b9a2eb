// Loop closures, and a person's word on them. What each returns and fails with is said in
// api/isthmus/v1/graph_service.proto.
#pragma once

#include <absl/status/statusor.h>

#include "isthmus/v1/graph_service.pb.h"
#include "server/pipeline.h"

namespace isthmus::rpc {

absl::StatusOr<v1::ListLoopsResponse> ListLoops(server::Pipeline& pipeline,
                                                const v1::ListLoopsRequest& request);
absl::StatusOr<v1::DecideLoopResponse> DecideLoop(server::Pipeline& pipeline,
                                                  const v1::DecideLoopRequest& request);

}  // namespace isthmus::rpc
