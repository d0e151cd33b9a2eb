// GraphService.ExportPoseGraph; see api/isthmus/v1/graph_service.proto.
#pragma once

#include <absl/status/status.h>

#include "isthmus/v1/graph_service.pb.h"
#include "server/pipeline.h"
#include "server/rpc/emit.h"

namespace isthmus::rpc {

absl::Status ExportPoseGraph(server::Pipeline& pipeline, const v1::ExportPoseGraphRequest& request,
                             const Emit<v1::ExportPoseGraphResponse>& emit);

}  // namespace isthmus::rpc
