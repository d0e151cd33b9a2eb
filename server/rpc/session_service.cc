#include "server/rpc/session_service.h"

#include <absl/strings/str_cat.h>

#include <utility>

#include "api/convert/session.h"
#include "server/rpc/decoded_submap.h"
#include "server/rpc/responses.h"
#include "server/rpc/scans/stream_scans.h"
#include "server/rpc/upload_submap.h"

namespace isthmus::rpc {

grpc::Status SessionService::CreateSession(grpc::ServerContext*,
                                           const v1::CreateSessionRequest* request,
                                           v1::Session* response) {
  return reply_("CreateSession", [&]() -> absl::Status {
    const auto wanted = convert::FromMessage(*request);
    if (!wanted.ok()) return wanted.status();
    const auto session = pipeline_.CreateSession(*wanted);
    if (session.ok()) *response = convert::ToMessage(*session);
    return session.status();
  });
}

grpc::Status SessionService::GetSession(grpc::ServerContext*, const v1::GetSessionRequest* request,
                                        v1::Session* response) {
  return reply_("GetSession", [&]() -> absl::Status {
    const auto session = pipeline_.GetSession(SessionId(request->session()));
    if (session.ok()) *response = convert::ToMessage(*session);
    return session.status();
  });
}

grpc::Status SessionService::ListSessions(grpc::ServerContext*, const v1::ListSessionsRequest*,
                                          grpc::ServerWriter<v1::ListSessionsResponse>* writer) {
  return reply_("ListSessions", [&]() -> absl::Status {
    ListEmitter<v1::ListSessionsResponse> list({}, writer);
    for (const SessionStatus& status : pipeline_.ListSessions()) {
      list.Add(&v1::ListSessionsResponse::mutable_sessions, convert::ToMessage(status));
    }
    return list.Finish();
  });
}

grpc::Status SessionService::FinishSession(grpc::ServerContext*,
                                           const v1::FinishSessionRequest* request,
                                           v1::Session* response) {
  return reply_("FinishSession", [&]() -> absl::Status {
    const SessionId session(request->session());
    if (request->last_sequence() > 0) {
      // It only falls behind this if the process is started anew, and this call ends with it.
      const auto status = pipeline_.GetSession(session);
      if (!status.ok()) return status.status();
      if (status->last_sequence < request->last_sequence()) {
        return absl::AbortedError(absl::StrCat(
            "session ", session.value(), " has scans up to ", status->last_sequence, " of ",
            request->last_sequence(), ": send the rest again, then finish it"));
      }
    }
    const auto finished = pipeline_.FinishSession(session);
    if (finished.ok()) {
      staging_.DropSession(session);
      *response = convert::ToMessage(*finished);
    }
    return finished.status();
  });
}

grpc::Status SessionService::StreamScans(
    grpc::ServerContext* context,
    grpc::ServerReaderWriter<v1::StreamScansResponse, v1::StreamScansRequest>* stream) {
  return reply_("StreamScans", [&]() -> absl::Status {
    ScanLink link;
    link.read = [stream](v1::StreamScansRequest* request) { return stream->Read(request); };
    link.write = [stream](const v1::StreamScansResponse& ack) { return stream->Write(ack); };
    link.cancel = [context] { context->TryCancel(); };
    return rpc::StreamScans(pipeline_, streams_, link);
  });
}

absl::StatusOr<SubmapInfo> SessionService::Receive(
    grpc::ServerReader<v1::UploadSubmapRequest>* reader) {
  SubmapReceiver receiver(max_submap_bytes_, staging_);
  v1::UploadSubmapRequest part;
  RobotId robot;
  while (reader->Read(&part)) {
    if (robot.empty() && part.has_header()) {
      // Asked before the bytes come, so that a wrong name costs nothing.
      const auto session = pipeline_.GetSession(SessionId(part.header().session()));
      if (!session.ok()) return session.status();
      robot = session->record.robot;
    }
    if (absl::Status status = receiver.Add(std::move(part)); !status.ok()) return status;
  }
  auto header = receiver.Finish();
  if (!header.ok()) return header.status();
  const SubmapId id{SessionId(header->session()), header->index()};
  auto upload = convert::FromMessage(*std::move(header));
  auto submap = upload.ok() ? DecodeSubmap(*std::move(upload), robot) : upload.status();
  auto info = submap.ok() ? pipeline_.AddSubmap(*std::move(submap)) : submap.status();
  // An upload that fails for a while need not travel again.
  const bool may_come = absl::IsUnavailable(info.status()) ||
                        absl::IsResourceExhausted(info.status()) ||
                        absl::IsOutOfRange(info.status());
  if (!may_come) staging_.Drop(id);
  return info;
}

grpc::Status SessionService::UploadSubmap(grpc::ServerContext*,
                                          grpc::ServerReader<v1::UploadSubmapRequest>* reader,
                                          v1::UploadSubmapResponse* response) {
  return reply_("UploadSubmap", [&]() -> absl::Status {
    const auto info = Receive(reader);
    if (!info.ok()) return info.status();
    response->set_session(info->id.session.value());
    response->set_index(info->id.index);
    response->set_point_count(info->point_count);
    return absl::OkStatus();
  });
}

grpc::Status SessionService::GetUpload(grpc::ServerContext*, const v1::GetUploadRequest* request,
                                       v1::GetUploadResponse* response) {
  return reply_("GetUpload", [&]() -> absl::Status {
    const SessionId session(request->session());
    const auto known = pipeline_.GetSession(session);
    if (known.ok()) {
      response->set_persisted(staging_.Persisted(
          {{session, request->index()}, request->size(), request->crc32c(), request->sha256()}));
    }
    return known.status();
  });
}

}  // namespace isthmus::rpc
