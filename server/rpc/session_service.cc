// Robots' data on its way in: sessions, scans, finished submaps. What each method returns and fails
// with is said in api/isthmus/v1/session_service.proto.
#include <absl/strings/str_cat.h>

#include <utility>

#include "api/convert/session.h"
#include "isthmus/v1/session_service.grpc.pb.h"
#include "server/rpc/responses.h"
#include "server/rpc/scans/stream_scans.h"
#include "server/rpc/services.h"
#include "server/rpc/upload_stream.h"

namespace isthmus::rpc {
namespace {

// A client can hold these without saying anything: they hold no thread.
using SessionServiceBase = v1::SessionService::WithRawCallbackMethod_StreamScans<
    v1::SessionService::WithRawCallbackMethod_UploadSubmap<v1::SessionService::Service>>;

class SessionService final : public SessionServiceBase {
 public:
  explicit SessionService(const ServiceParts& parts)
      : gate_(parts.gate), host_(parts.host), max_submap_bytes_(parts.max_submap_bytes) {}

  grpc::Status CreateSession(grpc::ServerContext* context, const v1::CreateSessionRequest* request,
                             v1::Session* response) override {
    return gate_.Serve(context, *request, "CreateSession", [&](const Call& call) -> absl::Status {
      const auto wanted = convert::FromMessage(*request);
      if (!wanted.ok()) return wanted.status();
      if (absl::Status own = call.CheckRobot(wanted->robot); !own.ok()) return own;
      const auto session = call.pipeline().sessions().Create(*wanted, call.actor());
      if (session.ok()) *response = convert::ToMessage(*session);
      return session.status();
    });
  }

  grpc::Status GetSession(grpc::ServerContext* context, const v1::GetSessionRequest* request,
                          v1::Session* response) override {
    return gate_.Serve(context, *request, "GetSession", [&](const Call& call) -> absl::Status {
      const auto session = call.OwnSession(SessionId(request->session()));
      if (session.ok()) *response = convert::ToMessage(*session);
      return session.status();
    });
  }

  grpc::Status ListSessions(grpc::ServerContext* context, const v1::ListSessionsRequest* request,
                            grpc::ServerWriter<v1::ListSessionsResponse>* writer) override {
    return gate_.Serve(context, *request, "ListSessions", [&](const Call& call) -> absl::Status {
      ListEmitter<v1::ListSessionsResponse> list(call, {}, writer);
      for (const SessionStatus& status : call.pipeline().sessions().List()) {
        if (!call.MayKnow(status)) continue;
        list.Add(&v1::ListSessionsResponse::mutable_sessions, convert::ToMessage(status));
      }
      return list.Finish();
    });
  }

  grpc::Status FinishSession(grpc::ServerContext* context, const v1::FinishSessionRequest* request,
                             v1::Session* response) override {
    return gate_.Serve(context, *request, "FinishSession", [&](const Call& call) -> absl::Status {
      const SessionId session(request->session());
      // An operator finishes what a robot that died left open; a reader what it feeds itself.
      const bool is_reader = call.caller.role == access::Role::kReader;
      const auto status = is_reader ? call.FedSession(session) : call.OwnSession(session);
      if (!status.ok()) return status.status();
      if (request->last_sequence() > 0) {
        // It only falls behind this if the process is started anew, and this call ends with it.
        if (status->last_sequence < request->last_sequence()) {
          return absl::AbortedError(absl::StrCat(
              "session ", session.value(), " has scans up to ", status->last_sequence, " of ",
              request->last_sequence(), ": send the rest again, then finish it"));
        }
      }
      const auto finished = call.pipeline().sessions().Finish(session, call.actor());
      if (finished.ok()) {
        call.site->staging.DropSession(session);
        *response = convert::ToMessage(*finished);
      }
      return finished.status();
    });
  }

  grpc::ServerBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer>* StreamScans(
      grpc::CallbackServerContext* context) override {
    return ScanReactorBase::Begin<ScanReactor>(&host_, context);
  }

  grpc::ServerReadReactor<grpc::ByteBuffer>* UploadSubmap(grpc::CallbackServerContext* context,
                                                          grpc::ByteBuffer* response) override {
    return UploadReactorBase::Begin<UploadReactor>(&host_, context, response, max_submap_bytes_);
  }

  grpc::Status GetUpload(grpc::ServerContext* context, const v1::GetUploadRequest* request,
                         v1::GetUploadResponse* response) override {
    return gate_.Serve(context, *request, "GetUpload", [&](const Call& call) -> absl::Status {
      const SessionId session(request->session());
      if (absl::Status status = CheckSha256(request->sha256()); !status.ok()) return status;
      const auto known = call.FedSession(session);
      if (known.ok()) {
        response->set_persisted(call.site->staging.Persisted(
            {{session, request->index()}, request->size(), request->crc32c(), request->sha256()}));
      }
      return known.status();
    });
  }

 private:
  Gate& gate_;
  StreamHost& host_;
  const uint64_t max_submap_bytes_;
};

}  // namespace

std::unique_ptr<grpc::Service> MakeSessionService(const ServiceParts& parts) {
  return std::make_unique<SessionService>(parts);
}

}  // namespace isthmus::rpc
