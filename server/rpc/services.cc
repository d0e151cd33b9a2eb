#include "server/rpc/services.h"

#include <string>
#include <utility>

#include "core/caught.h"
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

// What a handler throws is the answer to that call alone.
template <typename Handler>
auto Answer(const Handler& handler) -> decltype(handler()) {
  try {
    return handler();
  } catch (...) {
    return CaughtStatus();
  }
}

grpc::Status Reply(const ServerOptions& options, const char* rpc, const absl::Status& status) {
  if (!status.ok() && options.on_failed_call) options.on_failed_call(rpc, status);
  return ToGrpc(status);
}

template <typename Handler>
grpc::Status Reply(const ServerOptions& options, const char* rpc, const Handler& handler) {
  return Reply(options, rpc, Answer(handler));
}

template <typename Handler, typename Response>
grpc::Status Reply(const ServerOptions& options, const char* rpc, const Handler& handler,
                   Response* response) {
  absl::StatusOr<Response> result = Answer(handler);
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
  return Reply(
      options_, "CreateSession", [&] { return rpc::CreateSession(pipeline_, *request); }, response);
}

grpc::Status SessionServiceImpl::GetSession(grpc::ServerContext*,
                                            const v1::GetSessionRequest* request,
                                            v1::Session* response) {
  return Reply(
      options_, "GetSession", [&] { return rpc::GetSession(pipeline_, *request); }, response);
}

grpc::Status SessionServiceImpl::ListSessions(grpc::ServerContext*,
                                              const v1::ListSessionsRequest* request,
                                              v1::ListSessionsResponse* response) {
  return Reply(
      options_, "ListSessions", [&] { return rpc::ListSessions(pipeline_, *request); }, response);
}

grpc::Status SessionServiceImpl::FinishSession(grpc::ServerContext*,
                                               const v1::FinishSessionRequest* request,
                                               v1::Session* response) {
  const auto finish = [&] {
    auto result = rpc::FinishSession(pipeline_, *request);
    if (result.ok()) staging_.DropSession(SessionId(request->session()));
    return result;
  };
  return Reply(options_, "FinishSession", finish, response);
}

grpc::Status SessionServiceImpl::DeleteSession(grpc::ServerContext*,
                                               const v1::DeleteSessionRequest* request,
                                               v1::DeleteSessionResponse* response) {
  const auto remove = [&] {
    auto result = rpc::DeleteSession(pipeline_, *request);
    // Its queued scans are gone without acknowledgement: a stream would wait for them for ever.
    if (result.ok()) {
      streams_.Drop(SessionId(request->session()));
      staging_.DropSession(SessionId(request->session()));
    }
    return result;
  };
  return Reply(options_, "DeleteSession", remove, response);
}

grpc::Status SessionServiceImpl::StreamScans(
    grpc::ServerContext* context,
    grpc::ServerReaderWriter<v1::StreamScansResponse, v1::StreamScansRequest>* stream) {
  ScanLink link;
  link.read = [stream](v1::StreamScansRequest* request) { return stream->Read(request); };
  link.write = [stream](const v1::StreamScansResponse& ack) { return stream->Write(ack); };
  link.cancel = [context] { context->TryCancel(); };
  return Reply(options_, "StreamScans",
               [&] { return rpc::StreamScans(pipeline_, streams_, link); });
}

grpc::Status SessionServiceImpl::UploadSubmap(grpc::ServerContext*,
                                              grpc::ServerReader<v1::UploadSubmapRequest>* reader,
                                              v1::UploadSubmapResponse* response) {
  const auto read = [reader](v1::UploadSubmapRequest* part) { return reader->Read(part); };
  return Reply(
      options_, "UploadSubmap",
      [&] { return rpc::UploadSubmap(pipeline_, staging_, options_.max_submap_bytes, read); },
      response);
}

grpc::Status SessionServiceImpl::GetUpload(grpc::ServerContext*,
                                           const v1::GetUploadRequest* request,
                                           v1::GetUploadResponse* response) {
  return Reply(
      options_, "GetUpload", [&] { return rpc::GetUpload(pipeline_, staging_, *request); },
      response);
}

grpc::Status MapServiceImpl::GetMapInfo(grpc::ServerContext*, const v1::GetMapInfoRequest* request,
                                        v1::MapInfo* response) {
  return Reply(
      options_, "GetMapInfo", [&] { return rpc::GetMapInfo(pipeline_, *request); }, response);
}

grpc::Status MapServiceImpl::ListSubmaps(grpc::ServerContext*,
                                         const v1::ListSubmapsRequest* request,
                                         v1::ListSubmapsResponse* response) {
  return Reply(
      options_, "ListSubmaps", [&] { return rpc::ListSubmaps(pipeline_, *request); }, response);
}

grpc::Status MapServiceImpl::GetTrajectory(grpc::ServerContext*,
                                           const v1::GetTrajectoryRequest* request,
                                           grpc::ServerWriter<v1::GetTrajectoryResponse>* writer) {
  return Reply(options_, "GetTrajectory",
               [&] { return rpc::GetTrajectory(pipeline_, *request, EmitTo(writer)); });
}

grpc::Status MapServiceImpl::GetMatchGraph(grpc::ServerContext*,
                                           const v1::GetMatchGraphRequest* request,
                                           v1::MatchGraph* response) {
  return Reply(
      options_, "GetMatchGraph", [&] { return rpc::GetMatchGraph(pipeline_, *request); }, response);
}

grpc::Status MapServiceImpl::GetTransform(grpc::ServerContext*,
                                          const v1::GetTransformRequest* request,
                                          v1::GetTransformResponse* response) {
  return Reply(
      options_, "GetTransform", [&] { return rpc::GetTransform(pipeline_, *request); }, response);
}

grpc::Status MapServiceImpl::QueryRegion(grpc::ServerContext*,
                                         const v1::QueryRegionRequest* request,
                                         grpc::ServerWriter<v1::QueryRegionResponse>* writer) {
  return Reply(options_, "QueryRegion",
               [&] { return rpc::QueryRegion(pipeline_, *request, EmitTo(writer)); });
}

grpc::Status MapServiceImpl::ExportMap(grpc::ServerContext*, const v1::ExportMapRequest* request,
                                       grpc::ServerWriter<v1::ExportMapResponse>* writer) {
  return Reply(options_, "ExportMap",
               [&] { return rpc::ExportMap(pipeline_, *request, EmitTo(writer)); });
}

grpc::Status MatchServiceImpl::DecideMatch(grpc::ServerContext*,
                                           const v1::DecideMatchRequest* request,
                                           v1::DecideMatchResponse* response) {
  return Reply(
      options_, "DecideMatch", [&] { return rpc::DecideMatch(pipeline_, *request); }, response);
}

grpc::Status GraphServiceImpl::ListRevisions(grpc::ServerContext*,
                                             const v1::ListRevisionsRequest* request,
                                             v1::ListRevisionsResponse* response) {
  return Reply(
      options_, "ListRevisions", [&] { return rpc::ListRevisions(pipeline_, *request); }, response);
}

grpc::Status GraphServiceImpl::DiffRevisions(
    grpc::ServerContext*, const v1::DiffRevisionsRequest* request,
    grpc::ServerWriter<v1::DiffRevisionsResponse>* writer) {
  return Reply(options_, "DiffRevisions",
               [&] { return rpc::DiffRevisions(pipeline_, *request, EmitTo(writer)); });
}

grpc::Status GraphServiceImpl::UndoRevision(grpc::ServerContext*,
                                            const v1::UndoRevisionRequest* request,
                                            v1::UndoRevisionResponse* response) {
  return Reply(
      options_, "UndoRevision", [&] { return rpc::UndoRevision(pipeline_, *request); }, response);
}

grpc::Status GraphServiceImpl::ListLoops(grpc::ServerContext*, const v1::ListLoopsRequest* request,
                                         v1::ListLoopsResponse* response) {
  return Reply(
      options_, "ListLoops", [&] { return rpc::ListLoops(pipeline_, *request); }, response);
}

grpc::Status GraphServiceImpl::DecideLoop(grpc::ServerContext*,
                                          const v1::DecideLoopRequest* request,
                                          v1::DecideLoopResponse* response) {
  return Reply(
      options_, "DecideLoop", [&] { return rpc::DecideLoop(pipeline_, *request); }, response);
}

grpc::Status GraphServiceImpl::PutAnchor(grpc::ServerContext*, const v1::PutAnchorRequest* request,
                                         v1::PutAnchorResponse* response) {
  return Reply(
      options_, "PutAnchor", [&] { return rpc::PutAnchor(pipeline_, *request); }, response);
}

grpc::Status GraphServiceImpl::DeleteAnchor(grpc::ServerContext*,
                                            const v1::DeleteAnchorRequest* request,
                                            v1::DeleteAnchorResponse* response) {
  return Reply(
      options_, "DeleteAnchor", [&] { return rpc::DeleteAnchor(pipeline_, *request); }, response);
}

grpc::Status GraphServiceImpl::ListAnchors(grpc::ServerContext*,
                                           const v1::ListAnchorsRequest* request,
                                           v1::ListAnchorsResponse* response) {
  return Reply(
      options_, "ListAnchors", [&] { return rpc::ListAnchors(pipeline_, *request); }, response);
}

grpc::Status GraphServiceImpl::ExportPoseGraph(
    grpc::ServerContext*, const v1::ExportPoseGraphRequest* request,
    grpc::ServerWriter<v1::ExportPoseGraphResponse>* writer) {
  return Reply(options_, "ExportPoseGraph",
               [&] { return rpc::ExportPoseGraph(pipeline_, *request, EmitTo(writer)); });
}

grpc::Status AdminServiceImpl::BackUp(grpc::ServerContext*, const v1::BackUpRequest* request,
                                      grpc::ServerWriter<v1::BackUpResponse>* writer) {
  return Reply(options_, "BackUp", [&] {
    return rpc::BackUp(pipeline_, options_.backup, backing_up_, *request, EmitTo(writer));
  });
}

}  // namespace isthmus::rpc
