// Places of submaps that are known from outside. What each returns and fails with is said in
// api/isthmus/v1/graph_service.proto.
#pragma once

#include <absl/status/statusor.h>

#include "isthmus/v1/graph_service.pb.h"
#include "server/pipeline.h"

namespace isthmus::rpc {

absl::StatusOr<v1::PutAnchorResponse> PutAnchor(server::Pipeline& pipeline,
                                                const v1::PutAnchorRequest& request);
absl::StatusOr<v1::DeleteAnchorResponse> DeleteAnchor(server::Pipeline& pipeline,
                                                      const v1::DeleteAnchorRequest& request);
absl::StatusOr<v1::ListAnchorsResponse> ListAnchors(server::Pipeline& pipeline,
                                                    const v1::ListAnchorsRequest& request);

}  // namespace isthmus::rpc
