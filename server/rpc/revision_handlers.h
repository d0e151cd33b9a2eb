// Handlers that tell how the map changed, and that take a change back. What each returns and fails
// with is said in api/isthmus/v1/graph_service.proto.
#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include "isthmus/v1/graph_service.pb.h"
#include "server/pipeline.h"
#include "server/rpc/emit.h"

namespace isthmus::rpc {

absl::StatusOr<v1::ListRevisionsResponse> ListRevisions(server::Pipeline& pipeline,
                                                        const v1::ListRevisionsRequest& request);
absl::Status DiffRevisions(server::Pipeline& pipeline, const v1::DiffRevisionsRequest& request,
                           const Emit<v1::DiffRevisionsResponse>& emit);
absl::StatusOr<v1::UndoRevisionResponse> UndoRevision(server::Pipeline& pipeline,
                                                      const v1::UndoRevisionRequest& request);

}  // namespace isthmus::rpc
