#include "server/rpc/session_service.h"

#include <absl/strings/str_cat.h>

#include <utility>

#include "api/convert/session.h"
#include "server/rpc/decoded_submap.h"
#include "server/rpc/responses.h"
#include "server/rpc/scans/stream_scans.h"
#include "server/rpc/upload_submap.h"

namespace isthmus::rpc {

grpc::Status SessionService::CreateSession(grpc::ServerContext* context,
                                           const v1::CreateSessionRequest* request,
                                           v1::Session* response) {
  return gate_.Serve(context, "CreateSession", [&](const Call& call) -> absl::Status {
    const auto wanted = convert::FromMessage(*request);
    if (!wanted.ok()) return wanted.status();
    if (absl::Status own = call.CheckRobot(wanted->robot); !own.ok()) return own;
    const auto session = call.pipeline().CreateSession(*wanted);
    if (session.ok()) *response = convert::ToMessage(*session);
    return session.status();
  });
}

grpc::Status SessionService::GetSession(grpc::ServerContext* context,
                                        const v1::GetSessionRequest* request,
                                        v1::Session* response) {
  return gate_.Serve(context, "GetSession", [&](const Call& call) -> absl::Status {
    const auto session = call.OwnSession(SessionId(request->session()));
    if (session.ok()) *response = convert::ToMessage(*session);
    return session.status();
  });
}

grpc::Status SessionService::ListSessions(grpc::ServerContext* context,
                                          const v1::ListSessionsRequest*,
                                          grpc::ServerWriter<v1::ListSessionsResponse>* writer) {
  return gate_.Serve(context, "ListSessions", [&](const Call& call) -> absl::Status {
    ListEmitter<v1::ListSessionsResponse> list(call, {}, writer);
    for (const SessionStatus& status : call.pipeline().ListSessions()) {
      if (!call.MayKnow(status)) continue;
      list.Add(&v1::ListSessionsResponse::mutable_sessions, convert::ToMessage(status));
    }
    return list.Finish();
  });
}

grpc::Status SessionService::FinishSession(grpc::ServerContext* context,
                                           const v1::FinishSessionRequest* request,
                                           v1::Session* response) {
  return gate_.Serve(context, "FinishSession", [&](const Call& call) -> absl::Status {
    const SessionId session(request->session());
    const auto status = call.OwnSession(session);
    if (!status.ok()) return status.status();
    if (request->last_sequence() > 0) {
      // It only falls behind this if the process is started anew, and this call ends with it.
      if (status->last_sequence < request->last_sequence()) {
        return absl::AbortedError(absl::StrCat(
            "session ", session.value(), " has scans up to ", status->last_sequence, " of ",
            request->last_sequence(), ": send the rest again, then finish it"));
      }
    }
    const auto finished = call.pipeline().FinishSession(session);
    if (finished.ok()) {
      call.site->staging.DropSession(session);
      *response = convert::ToMessage(*finished);
    }
    return finished.status();
  });
}

grpc::Status SessionService::StreamScans(
    grpc::ServerContext* context,
    grpc::ServerReaderWriter<v1::StreamScansResponse, v1::StreamScansRequest>* stream) {
  return gate_.Serve(context, "StreamScans", [&](const Call& call) -> absl::Status {
    ScanLink link;
    link.read = [stream](v1::StreamScansRequest* request) { return stream->Read(request); };
    link.write = [stream](const v1::StreamScansResponse& ack) { return stream->Write(ack); };
    link.cancel = [context] { context->TryCancel(); };
    return rpc::StreamScans(call, link);
  });
}

absl::StatusOr<SubmapInfo> SessionService::Receive(
    const Call& call, grpc::ServerReader<v1::UploadSubmapRequest>* reader) {
  SubmapReceiver receiver(max_submap_bytes_, call.site->staging);
  v1::UploadSubmapRequest part;
  RobotId robot;
  while (reader->Read(&part)) {
    if (robot.empty() && part.has_header()) {
      // Asked before the bytes come, so that a wrong name costs nothing.
      const auto session = call.OwnSession(SessionId(part.header().session()));
      if (!session.ok()) return session.status();
      robot = session->record.robot;
    }
    if (absl::Status allowed = call.Allowed(); !allowed.ok()) return allowed;
    if (absl::Status status = receiver.Add(std::move(part)); !status.ok()) return status;
  }
  auto header = receiver.Finish();
  if (!header.ok()) return header.status();
  const SubmapId id{SessionId(header->session()), header->index()};
  auto upload = convert::FromMessage(*std::move(header));
  auto submap = upload.ok() ? DecodeSubmap(*std::move(upload), robot) : upload.status();
  auto info = submap.ok() ? call.pipeline().AddSubmap(*std::move(submap)) : submap.status();
  // An upload that fails for a while need not travel again.
  const bool may_come = absl::IsUnavailable(info.status()) ||
                        absl::IsResourceExhausted(info.status()) ||
                        absl::IsOutOfRange(info.status());
  if (!may_come) call.site->staging.Drop(id);
  return info;
}

grpc::Status SessionService::UploadSubmap(grpc::ServerContext* context,
                                          grpc::ServerReader<v1::UploadSubmapRequest>* reader,
                                          v1::UploadSubmapResponse* response) {
  return gate_.Serve(context, "UploadSubmap", [&](const Call& call) -> absl::Status {
    const auto info = Receive(call, reader);
    if (!info.ok()) return info.status();
    response->set_session(info->id.session.value());
    response->set_index(info->id.index);
    response->set_point_count(info->point_count);
    return absl::OkStatus();
  });
}

grpc::Status SessionService::GetUpload(grpc::ServerContext* context,
                                       const v1::GetUploadRequest* request,
                                       v1::GetUploadResponse* response) {
  return gate_.Serve(context, "GetUpload", [&](const Call& call) -> absl::Status {
    const SessionId session(request->session());
    const auto known = call.OwnSession(session);
    if (known.ok()) {
      response->set_persisted(call.site->staging.Persisted(
          {{session, request->index()}, request->size(), request->crc32c(), request->sha256()}));
    }
    return known.status();
  });
}

}  // namespace isthmus::rpc
