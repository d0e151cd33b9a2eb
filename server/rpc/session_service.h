// Robots' data on its way in: sessions, scans, finished submaps. What each method returns and fails
// with is said in api/isthmus/v1/session_service.proto.
#pragma once

#include <grpcpp/server_context.h>
#include <grpcpp/support/byte_buffer.h>
#include <grpcpp/support/server_callback.h>
#include <grpcpp/support/status.h>
#include <grpcpp/support/sync_stream.h>

#include <cstdint>

#include "isthmus/v1/session_service.grpc.pb.h"
#include "server/rpc/gate.h"
#include "server/rpc/streams/stream_host.h"

namespace isthmus::rpc {

// A client can hold these without saying anything: they hold no thread.
using SessionServiceBase = v1::SessionService::WithRawCallbackMethod_StreamScans<
    v1::SessionService::WithRawCallbackMethod_UploadSubmap<v1::SessionService::Service>>;

// Thread safe. Whatever it is given must outlive it.
class SessionService final : public SessionServiceBase {
 public:
  // At most `max_submap_bytes` are taken of an upload, as they travel.
  SessionService(Gate* gate, StreamHost* host, uint64_t max_submap_bytes)
      : gate_(*gate), host_(*host), max_submap_bytes_(max_submap_bytes) {}

  grpc::Status CreateSession(grpc::ServerContext* context, const v1::CreateSessionRequest* request,
                             v1::Session* response) override;
  grpc::Status GetSession(grpc::ServerContext* context, const v1::GetSessionRequest* request,
                          v1::Session* response) override;
  grpc::Status ListSessions(grpc::ServerContext* context, const v1::ListSessionsRequest* request,
                            grpc::ServerWriter<v1::ListSessionsResponse>* writer) override;
  grpc::Status FinishSession(grpc::ServerContext* context, const v1::FinishSessionRequest* request,
                             v1::Session* response) override;
  grpc::ServerBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer>* StreamScans(
      grpc::CallbackServerContext* context) override;
  grpc::ServerReadReactor<grpc::ByteBuffer>* UploadSubmap(grpc::CallbackServerContext* context,
                                                          grpc::ByteBuffer* response) override;
  grpc::Status GetUpload(grpc::ServerContext* context, const v1::GetUploadRequest* request,
                         v1::GetUploadResponse* response) override;

 private:
  Gate& gate_;
  StreamHost& host_;
  const uint64_t max_submap_bytes_;
};

}  // namespace isthmus::rpc
