// Answers of MapService that are longer than a line or two; each writes what it is asked for.
#pragma once

#include <absl/status/status.h>
#include <grpcpp/support/sync_stream.h>

#include <cstdint>

#include "isthmus/v1/map_service.pb.h"
#include "server/rpc/call.h"

namespace isthmus::rpc {

// Positions of another run of the server mean nothing here.
absl::Status SendRegion(const Call& call, const v1::QueryRegionRequest& request,
                        uint64_t run_of_server,
                        grpc::ServerWriter<v1::QueryRegionResponse>* writer);
absl::Status SendChanges(const Call& call, const v1::FindChangesRequest& request,
                         grpc::ServerWriter<v1::FindChangesResponse>* writer);
absl::Status SendMap(const Call& call, const v1::ExportMapRequest& request,
                     grpc::ServerWriter<v1::ExportMapResponse>* writer);
absl::Status SendPoseGraph(const Call& call, const v1::ExportPoseGraphRequest& request,
                           grpc::ServerWriter<v1::ExportPoseGraphResponse>* writer);
absl::Status SendTiles(const Call& call, const v1::ListTilesRequest& request,
                       grpc::ServerWriter<v1::ListTilesResponse>* writer);
absl::Status SendTile(const Call& call, const v1::GetTileRequest& request,
                      grpc::ServerWriter<v1::GetTileResponse>* writer);

}  // namespace isthmus::rpc
