// MapService.ExportMap; see api/isthmus/v1/map_service.proto.
#pragma once

#include <absl/status/status.h>

#include "isthmus/v1/map_service.pb.h"
#include "server/pipeline.h"
#include "server/rpc/emit.h"

namespace isthmus::rpc {

// Bytes of `data` in a response at the most.
inline constexpr size_t kExportChunkBytes = 1 << 20;

absl::Status ExportMap(server::Pipeline& pipeline, const v1::ExportMapRequest& request,
                       const Emit<v1::ExportMapResponse>& emit);

}  // namespace isthmus::rpc
