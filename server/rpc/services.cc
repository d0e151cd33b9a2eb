#include "server/rpc/services.h"

#include <string>
#include <utility>

#include "server/rpc/anchor_handlers.h"
#include "server/rpc/back_up.h"
#include "server/rpc/export_map.h"
#include "server/rpc/export_pose_graph.h"
#include "server/rpc/loop_handlers.h"
#include "server/rpc/map_handlers.h"
#include "server/rpc/match_handlers.h"
#include "server/rpc/query_region.h"
#include "server/rpc/revision_handlers.h"
#include "server/rpc/session_handlers.h"
#include "server/rpc/stream_scans.h"
#include "server/rpc/upload_submap.h"

namespace isthmus::rpc {
namespace {

// Trailers are limited to 8 KiB; a message may quote what the client sent.
constexpr size_t kMaxMessage = 1024;

grpc::Status Reply(const ServerOptions& options, const char* rpc, const absl::Status& status) {
  if (!status.ok() && options.on_failed_call) options.on_failed_call(rpc, status);
  return ToGrpc(status);
}

template <typename Response>
grpc::Status Reply(const ServerOptions& options, const char* rpc, absl::StatusOr<Response> result,
                   Response* response) {
  if (result.ok()) *response = *std::move(result);
  return Reply(options, rpc, result.status());
}

template <typename Response>
Emit<Response> EmitTo(grpc::ServerWriter<Response>* writer) {
  return [writer](const Response& response) { return writer->Write(response); };
}

}  // namespace

grpc::Status ToGrpc(const absl::Status& status) {
  // absl's codes are gRPC's by design: https://abseil.io/docs/cpp/guides/status-codes
  const auto code = static_cast<grpc::StatusCode>(status.raw_code());
  return grpc::Status(code, std::string(status.message().substr(0, kMaxMessage)));
}

grpc::Status SessionServiceImpl::CreateSession(grpc::ServerContext*,
                                               const v1::CreateSessionRequest* request,
                                               v1::Session* response) {
  return Reply(options_, "CreateSession", rpc::CreateSession(pipeline_, *request), response);
}

grpc::Status SessionServiceImpl::GetSession(grpc::ServerContext*,
                                            const v1::GetSessionRequest* request,
                                            v1::Session* response) {
  return Reply(options_, "GetSession", rpc::GetSession(pipeline_, *request), response);
}

grpc::Status SessionServiceImpl::ListSessions(grpc::ServerContext*,
                                              const v1::ListSessionsRequest* request,
                                              v1::ListSessionsResponse* response) {
  return Reply(options_, "ListSessions", rpc::ListSessions(pipeline_, *request), response);
}

grpc::Status SessionServiceImpl::FinishSession(grpc::ServerContext*,
                                               const v1::FinishSessionRequest* request,
                                               v1::Session* response) {
  auto result = rpc::FinishSession(pipeline_, *request);
  if (result.ok()) staging_.DropSession(SessionId(request->session()));
  return Reply(options_, "FinishSession", std::move(result), response);
}

grpc::Status SessionServiceImpl::DeleteSession(grpc::ServerContext*,
                                               const v1::DeleteSessionRequest* request,
                                               v1::DeleteSessionResponse* response) {
  auto result = rpc::DeleteSession(pipeline_, *request);
  // Its queued scans are gone without acknowledgement: a stream would wait for them forever.
  if (result.ok()) {
    streams_.Drop(SessionId(request->session()));
    staging_.DropSession(SessionId(request->session()));
  }
  return Reply(options_, "DeleteSession", std::move(result), response);
}

grpc::Status SessionServiceImpl::StreamScans(
    grpc::ServerContext* context,
    grpc::ServerReaderWriter<v1::StreamScansResponse, v1::StreamScansRequest>* stream) {
  ScanLink link;
  link.read = [stream](v1::StreamScansRequest* request) { return stream->Read(request); };
  link.write = [stream](const v1::StreamScansResponse& ack) { return stream->Write(ack); };
  link.cancel = [context] { context->TryCancel(); };
  return Reply(options_, "StreamScans", rpc::StreamScans(pipeline_, streams_, link));
}

grpc::Status SessionServiceImpl::UploadSubmap(grpc::ServerContext*,
                                              grpc::ServerReader<v1::UploadSubmapRequest>* reader,
                                              v1::UploadSubmapResponse* response) {
  const auto read = [reader](v1::UploadSubmapRequest* part) { return reader->Read(part); };
  return Reply(options_, "UploadSubmap",
               rpc::UploadSubmap(pipeline_, staging_, options_.max_submap_bytes, read), response);
}

grpc::Status SessionServiceImpl::GetUpload(grpc::ServerContext*,
                                           const v1::GetUploadRequest* request,
                                           v1::GetUploadResponse* response) {
  return Reply(options_, "GetUpload", rpc::GetUpload(pipeline_, staging_, *request), response);
}

grpc::Status MapServiceImpl::GetMapInfo(grpc::ServerContext*, const v1::GetMapInfoRequest* request,
                                        v1::MapInfo* response) {
  return Reply(options_, "GetMapInfo", rpc::GetMapInfo(pipeline_, *request), response);
}

grpc::Status MapServiceImpl::ListSubmaps(grpc::ServerContext*,
                                         const v1::ListSubmapsRequest* request,
                                         v1::ListSubmapsResponse* response) {
  return Reply(options_, "ListSubmaps", rpc::ListSubmaps(pipeline_, *request), response);
}

grpc::Status MapServiceImpl::GetTrajectory(grpc::ServerContext*,
                                           const v1::GetTrajectoryRequest* request,
                                           grpc::ServerWriter<v1::GetTrajectoryResponse>* writer) {
  return Reply(options_, "GetTrajectory", rpc::GetTrajectory(pipeline_, *request, EmitTo(writer)));
}

grpc::Status MapServiceImpl::GetMatchGraph(grpc::ServerContext*,
                                           const v1::GetMatchGraphRequest* request,
                                           v1::MatchGraph* response) {
  return Reply(options_, "GetMatchGraph", rpc::GetMatchGraph(pipeline_, *request), response);
}

grpc::Status MapServiceImpl::GetTransform(grpc::ServerContext*,
                                          const v1::GetTransformRequest* request,
                                          v1::GetTransformResponse* response) {
  return Reply(options_, "GetTransform", rpc::GetTransform(pipeline_, *request), response);
}

grpc::Status MapServiceImpl::QueryRegion(grpc::ServerContext*,
                                         const v1::QueryRegionRequest* request,
                                         grpc::ServerWriter<v1::QueryRegionResponse>* writer) {
  return Reply(options_, "QueryRegion", rpc::QueryRegion(pipeline_, *request, EmitTo(writer)));
}

grpc::Status MapServiceImpl::ExportMap(grpc::ServerContext*, const v1::ExportMapRequest* request,
                                       grpc::ServerWriter<v1::ExportMapResponse>* writer) {
  return Reply(options_, "ExportMap", rpc::ExportMap(pipeline_, *request, EmitTo(writer)));
}

grpc::Status MatchServiceImpl::DecideMatch(grpc::ServerContext*,
                                           const v1::DecideMatchRequest* request,
                                           v1::DecideMatchResponse* response) {
  return Reply(options_, "DecideMatch", rpc::DecideMatch(pipeline_, *request), response);
}

grpc::Status GraphServiceImpl::ListRevisions(grpc::ServerContext*,
                                             const v1::ListRevisionsRequest* request,
                                             v1::ListRevisionsResponse* response) {
  return Reply(options_, "ListRevisions", rpc::ListRevisions(pipeline_, *request), response);
}

grpc::Status GraphServiceImpl::DiffRevisions(
    grpc::ServerContext*, const v1::DiffRevisionsRequest* request,
    grpc::ServerWriter<v1::DiffRevisionsResponse>* writer) {
  return Reply(options_, "DiffRevisions", rpc::DiffRevisions(pipeline_, *request, EmitTo(writer)));
}

grpc::Status GraphServiceImpl::UndoRevision(grpc::ServerContext*,
                                            const v1::UndoRevisionRequest* request,
                                            v1::UndoRevisionResponse* response) {
  return Reply(options_, "UndoRevision", rpc::UndoRevision(pipeline_, *request), response);
}

grpc::Status GraphServiceImpl::ListLoops(grpc::ServerContext*, const v1::ListLoopsRequest* request,
                                         v1::ListLoopsResponse* response) {
  return Reply(options_, "ListLoops", rpc::ListLoops(pipeline_, *request), response);
}

grpc::Status GraphServiceImpl::DecideLoop(grpc::ServerContext*,
                                          const v1::DecideLoopRequest* request,
                                          v1::DecideLoopResponse* response) {
  return Reply(options_, "DecideLoop", rpc::DecideLoop(pipeline_, *request), response);
}

grpc::Status GraphServiceImpl::PutAnchor(grpc::ServerContext*, const v1::PutAnchorRequest* request,
                                         v1::PutAnchorResponse* response) {
  return Reply(options_, "PutAnchor", rpc::PutAnchor(pipeline_, *request), response);
}

grpc::Status GraphServiceImpl::DeleteAnchor(grpc::ServerContext*,
                                            const v1::DeleteAnchorRequest* request,
                                            v1::DeleteAnchorResponse* response) {
  return Reply(options_, "DeleteAnchor", rpc::DeleteAnchor(pipeline_, *request), response);
}

grpc::Status GraphServiceImpl::ListAnchors(grpc::ServerContext*,
                                           const v1::ListAnchorsRequest* request,
                                           v1::ListAnchorsResponse* response) {
  return Reply(options_, "ListAnchors", rpc::ListAnchors(pipeline_, *request), response);
}

grpc::Status GraphServiceImpl::ExportPoseGraph(
    grpc::ServerContext*, const v1::ExportPoseGraphRequest* request,
    grpc::ServerWriter<v1::ExportPoseGraphResponse>* writer) {
  return Reply(options_, "ExportPoseGraph",
               rpc::ExportPoseGraph(pipeline_, *request, EmitTo(writer)));
}

grpc::Status AdminServiceImpl::BackUp(grpc::ServerContext*, const v1::BackUpRequest* request,
                                      grpc::ServerWriter<v1::BackUpResponse>* writer) {
  return Reply(options_, "BackUp",
               rpc::BackUp(pipeline_, options_.backup, backing_up_, *request, EmitTo(writer)));
}

}  // namespace isthmus::rpc
