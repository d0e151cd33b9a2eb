// MapService.QueryRegion; see api/isthmus/v1/map_service.proto.
#pragma once

#include <absl/status/status.h>

#include "isthmus/v1/map_service.pb.h"
#include "server/pipeline.h"
#include "server/rpc/emit.h"

namespace isthmus::rpc {

absl::Status QueryRegion(server::Pipeline& pipeline, const v1::QueryRegionRequest& request,
                         const Emit<v1::QueryRegionResponse>& emit);

}  // namespace isthmus::rpc
