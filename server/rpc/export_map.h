// MapService.ExportMap; see api/isthmus/v1/map_service.proto.
#pragma once

#include <absl/status/status.h>

#include "isthmus/v1/map_service.pb.h"
#include "server/pipeline.h"
#include "server/rpc/emit.h"

namespace isthmus::rpc {

absl::Status ExportMap(server::Pipeline& pipeline, const v1::ExportMapRequest& request,
                       const Emit<v1::ExportMapResponse>& emit);

}  // namespace isthmus::rpc
