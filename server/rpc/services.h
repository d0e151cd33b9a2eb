// The gRPC side of the handlers: which RPC calls which, and how a status travels.
#pragma once

#include <absl/status/status.h>
#include <grpcpp/support/status.h>

#include <atomic>

#include "isthmus/v1/admin_service.grpc.pb.h"
#include "isthmus/v1/graph_service.grpc.pb.h"
#include "isthmus/v1/map_service.grpc.pb.h"
#include "isthmus/v1/match_service.grpc.pb.h"
#include "isthmus/v1/session_service.grpc.pb.h"
#include "server/pipeline.h"
#include "server/rpc/scan_streams.h"
#include "server/rpc/server.h"
#include "server/rpc/upload_staging.h"

namespace isthmus::rpc {

// Same codes, same message; a message longer than what fits into a trailer is cut.
grpc::Status ToGrpc(const absl::Status& status);

class SessionServiceImpl final : public v1::SessionService::Service {
 public:
  SessionServiceImpl(server::Pipeline& pipeline, const ServerOptions& options)
      : pipeline_(pipeline),
        options_(options),
        streams_(pipeline, options.scan_window),
        staging_(options.uploads_folder, options.max_staged_bytes) {}

  ScanStreams& streams() { return streams_; }

  grpc::Status CreateSession(grpc::ServerContext* context, const v1::CreateSessionRequest* request,
                             v1::Session* response) override;
  grpc::Status GetSession(grpc::ServerContext* context, const v1::GetSessionRequest* request,
                          v1::Session* response) override;
  grpc::Status ListSessions(grpc::ServerContext* context, const v1::ListSessionsRequest* request,
                            v1::ListSessionsResponse* response) override;
  grpc::Status FinishSession(grpc::ServerContext* context, const v1::FinishSessionRequest* request,
                             v1::Session* response) override;
  grpc::Status DeleteSession(grpc::ServerContext* context, const v1::DeleteSessionRequest* request,
                             v1::DeleteSessionResponse* response) override;
  grpc::Status StreamScans(
      grpc::ServerContext* context,
      grpc::ServerReaderWriter<v1::StreamScansResponse, v1::StreamScansRequest>* stream) override;
  grpc::Status UploadSubmap(grpc::ServerContext* context,
                            grpc::ServerReader<v1::UploadSubmapRequest>* reader,
                            v1::UploadSubmapResponse* response) override;
  grpc::Status GetUpload(grpc::ServerContext* context, const v1::GetUploadRequest* request,
                         v1::GetUploadResponse* response) override;

 private:
  server::Pipeline& pipeline_;
  const ServerOptions options_;
  ScanStreams streams_;
  UploadStaging staging_;
};

class MapServiceImpl final : public v1::MapService::Service {
 public:
  MapServiceImpl(server::Pipeline& pipeline, const ServerOptions& options)
      : pipeline_(pipeline), options_(options) {}

  grpc::Status GetMapInfo(grpc::ServerContext* context, const v1::GetMapInfoRequest* request,
                          v1::MapInfo* response) override;
  grpc::Status ListSubmaps(grpc::ServerContext* context, const v1::ListSubmapsRequest* request,
                           v1::ListSubmapsResponse* response) override;
  grpc::Status GetTrajectory(grpc::ServerContext* context, const v1::GetTrajectoryRequest* request,
                             grpc::ServerWriter<v1::GetTrajectoryResponse>* writer) override;
  grpc::Status GetMatchGraph(grpc::ServerContext* context, const v1::GetMatchGraphRequest* request,
                             v1::MatchGraph* response) override;
  grpc::Status GetTransform(grpc::ServerContext* context, const v1::GetTransformRequest* request,
                            v1::GetTransformResponse* response) override;
  grpc::Status QueryRegion(grpc::ServerContext* context, const v1::QueryRegionRequest* request,
                           grpc::ServerWriter<v1::QueryRegionResponse>* writer) override;
  grpc::Status ExportMap(grpc::ServerContext* context, const v1::ExportMapRequest* request,
                         grpc::ServerWriter<v1::ExportMapResponse>* writer) override;

 private:
  server::Pipeline& pipeline_;
  const ServerOptions options_;
};

class MatchServiceImpl final : public v1::MatchService::Service {
 public:
  MatchServiceImpl(server::Pipeline& pipeline, const ServerOptions& options)
      : pipeline_(pipeline), options_(options) {}

  grpc::Status DecideMatch(grpc::ServerContext* context, const v1::DecideMatchRequest* request,
                           v1::DecideMatchResponse* response) override;

 private:
  server::Pipeline& pipeline_;
  const ServerOptions options_;
};

class GraphServiceImpl final : public v1::GraphService::Service {
 public:
  GraphServiceImpl(server::Pipeline& pipeline, const ServerOptions& options)
      : pipeline_(pipeline), options_(options) {}

  grpc::Status ListRevisions(grpc::ServerContext* context, const v1::ListRevisionsRequest* request,
                             v1::ListRevisionsResponse* response) override;
  grpc::Status DiffRevisions(grpc::ServerContext* context, const v1::DiffRevisionsRequest* request,
                             grpc::ServerWriter<v1::DiffRevisionsResponse>* writer) override;
  grpc::Status UndoRevision(grpc::ServerContext* context, const v1::UndoRevisionRequest* request,
                            v1::UndoRevisionResponse* response) override;
  grpc::Status ListLoops(grpc::ServerContext* context, const v1::ListLoopsRequest* request,
                         v1::ListLoopsResponse* response) override;
  grpc::Status DecideLoop(grpc::ServerContext* context, const v1::DecideLoopRequest* request,
                          v1::DecideLoopResponse* response) override;
  grpc::Status PutAnchor(grpc::ServerContext* context, const v1::PutAnchorRequest* request,
                         v1::PutAnchorResponse* response) override;
  grpc::Status DeleteAnchor(grpc::ServerContext* context, const v1::DeleteAnchorRequest* request,
                            v1::DeleteAnchorResponse* response) override;
  grpc::Status ListAnchors(grpc::ServerContext* context, const v1::ListAnchorsRequest* request,
                           v1::ListAnchorsResponse* response) override;
  grpc::Status ExportPoseGraph(grpc::ServerContext* context,
                               const v1::ExportPoseGraphRequest* request,
                               grpc::ServerWriter<v1::ExportPoseGraphResponse>* writer) override;

 private:
  server::Pipeline& pipeline_;
  const ServerOptions options_;
};

class AdminServiceImpl final : public v1::AdminService::Service {
 public:
  AdminServiceImpl(server::Pipeline& pipeline, const ServerOptions& options)
      : pipeline_(pipeline), options_(options) {}

  grpc::Status BackUp(grpc::ServerContext* context, const v1::BackUpRequest* request,
                      grpc::ServerWriter<v1::BackUpResponse>* writer) override;

 private:
  server::Pipeline& pipeline_;
  const ServerOptions options_;
  std::atomic<bool> backing_up_ = false;
};

}  // namespace isthmus::rpc
