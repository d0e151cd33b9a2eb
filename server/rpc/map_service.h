// Reading the map. api/isthmus/v1/map_service.proto says what each method returns and fails with.
#pragma once

#include <absl/status/status.h>
#include <grpcpp/server_context.h>
#include <grpcpp/support/byte_buffer.h>
#include <grpcpp/support/server_callback.h>
#include <grpcpp/support/status.h>
#include <grpcpp/support/sync_stream.h>

#include <cstdint>

#include "isthmus/v1/map_service.grpc.pb.h"
#include "server/rpc/gate.h"
#include "server/rpc/streams/stream_host.h"

namespace isthmus::rpc {

// A client can watch without end: that holds no thread.
using MapServiceBase = v1::MapService::WithRawCallbackMethod_WatchMap<v1::MapService::Service>;

// Thread safe. Whatever it is given must outlive it.
class MapService final : public MapServiceBase {
 public:
  MapService(Gate* gate, StreamHost* host);

  grpc::Status GetMapInfo(grpc::ServerContext* context, const v1::GetMapInfoRequest* request,
                          v1::MapInfo* response) override;
  grpc::Status ListSubmaps(grpc::ServerContext* context, const v1::ListSubmapsRequest* request,
                           grpc::ServerWriter<v1::ListSubmapsResponse>* writer) override;
  grpc::Status GetTrajectory(grpc::ServerContext* context, const v1::GetTrajectoryRequest* request,
                             grpc::ServerWriter<v1::GetTrajectoryResponse>* writer) override;
  grpc::Status GetMatchGraph(grpc::ServerContext* context, const v1::GetMatchGraphRequest* request,
                             grpc::ServerWriter<v1::GetMatchGraphResponse>* writer) override;
  grpc::Status ListLoops(grpc::ServerContext* context, const v1::ListLoopsRequest* request,
                         grpc::ServerWriter<v1::ListLoopsResponse>* writer) override;
  grpc::Status ListAnchors(grpc::ServerContext* context, const v1::ListAnchorsRequest* request,
                           grpc::ServerWriter<v1::ListAnchorsResponse>* writer) override;
  grpc::Status ListRevisions(grpc::ServerContext* context, const v1::ListRevisionsRequest* request,
                             grpc::ServerWriter<v1::ListRevisionsResponse>* writer) override;
  grpc::Status DiffRevisions(grpc::ServerContext* context, const v1::DiffRevisionsRequest* request,
                             grpc::ServerWriter<v1::DiffRevisionsResponse>* writer) override;
  grpc::Status GetTransform(grpc::ServerContext* context, const v1::GetTransformRequest* request,
                            v1::GetTransformResponse* response) override;

  // In map_region.cc.
  grpc::Status QueryRegion(grpc::ServerContext* context, const v1::QueryRegionRequest* request,
                           grpc::ServerWriter<v1::QueryRegionResponse>* writer) override;

  // In map_found_changes.cc.
  grpc::Status FindChanges(grpc::ServerContext* context, const v1::FindChangesRequest* request,
                           grpc::ServerWriter<v1::FindChangesResponse>* writer) override;

  // In map_files.cc.
  grpc::Status ExportMap(grpc::ServerContext* context, const v1::ExportMapRequest* request,
                         grpc::ServerWriter<v1::ExportMapResponse>* writer) override;
  grpc::Status ExportPoseGraph(grpc::ServerContext* context,
                               const v1::ExportPoseGraphRequest* request,
                               grpc::ServerWriter<v1::ExportPoseGraphResponse>* writer) override;

  // In map_tiles.cc.
  grpc::Status ListTiles(grpc::ServerContext* context, const v1::ListTilesRequest* request,
                         grpc::ServerWriter<v1::ListTilesResponse>* writer) override;
  grpc::Status GetTile(grpc::ServerContext* context, const v1::GetTileRequest* request,
                       grpc::ServerWriter<v1::GetTileResponse>* writer) override;
  grpc::ServerWriteReactor<grpc::ByteBuffer>* WatchMap(grpc::CallbackServerContext* context,
                                                       const grpc::ByteBuffer* request) override;

 private:
  absl::Status SendTiles(const Call& call, const v1::ListTilesRequest& request,
                         grpc::ServerWriter<v1::ListTilesResponse>* writer);
  absl::Status SendTile(const Call& call, const v1::GetTileRequest& request,
                        grpc::ServerWriter<v1::GetTileResponse>* writer);
  absl::Status SendRegion(const Call& call, const v1::QueryRegionRequest& request,
                          grpc::ServerWriter<v1::QueryRegionResponse>* writer);
  absl::Status SendMap(const Call& call, const v1::ExportMapRequest& request,
                       grpc::ServerWriter<v1::ExportMapResponse>* writer);

  Gate& gate_;
  StreamHost& host_;
  const uint64_t run_;  // This server's: positions of another one mean nothing here.
};

}  // namespace isthmus::rpc
