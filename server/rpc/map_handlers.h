// Reading the map, but for its points (query_region.h, export_map.h) and its
// matches (match_handlers.h). One function per RPC; what
// each returns and fails with is said in api/isthmus/v1/map_service.proto.
#pragma once

#include <absl/status/statusor.h>

#include "isthmus/v1/map_service.pb.h"
#include "server/pipeline.h"
#include "server/rpc/emit.h"

namespace isthmus::rpc {

absl::StatusOr<v1::MapInfo> GetMapInfo(server::Pipeline& pipeline,
                                       const v1::GetMapInfoRequest& request);
absl::StatusOr<v1::ListSubmapsResponse> ListSubmaps(server::Pipeline& pipeline,
                                                    const v1::ListSubmapsRequest& request);
absl::Status GetTrajectory(server::Pipeline& pipeline, const v1::GetTrajectoryRequest& request,
                           const Emit<v1::GetTrajectoryResponse>& emit);
absl::StatusOr<v1::GetTransformResponse> GetTransform(server::Pipeline& pipeline,
                                                      const v1::GetTransformRequest& request);

}  // namespace isthmus::rpc
