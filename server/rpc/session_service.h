// Robots' data on its way in: sessions, scans, finished submaps. What each method returns and fails
// with is said in api/isthmus/v1/session_service.proto.
#pragma once

#include <grpcpp/server_context.h>
#include <grpcpp/support/status.h>
#include <grpcpp/support/sync_stream.h>

#include <cstdint>

#include "isthmus/v1/session_service.grpc.pb.h"
#include "server/rpc/gate.h"

namespace isthmus::rpc {

// Thread safe. The gate must outlive it.
class SessionService final : public v1::SessionService::Service {
 public:
  // At most `max_submap_bytes` are taken of an upload, as they travel.
  SessionService(Gate* gate, uint64_t max_submap_bytes)
      : gate_(*gate), max_submap_bytes_(max_submap_bytes) {}

  grpc::Status CreateSession(grpc::ServerContext* context, const v1::CreateSessionRequest* request,
                             v1::Session* response) override;
  grpc::Status GetSession(grpc::ServerContext* context, const v1::GetSessionRequest* request,
                          v1::Session* response) override;
  grpc::Status ListSessions(grpc::ServerContext* context, const v1::ListSessionsRequest* request,
                            grpc::ServerWriter<v1::ListSessionsResponse>* writer) override;
  grpc::Status FinishSession(grpc::ServerContext* context, const v1::FinishSessionRequest* request,
                             v1::Session* response) override;
  grpc::Status StreamScans(
      grpc::ServerContext* context,
      grpc::ServerReaderWriter<v1::StreamScansResponse, v1::StreamScansRequest>* stream) override;
  grpc::Status UploadSubmap(grpc::ServerContext* context,
                            grpc::ServerReader<v1::UploadSubmapRequest>* reader,
                            v1::UploadSubmapResponse* response) override;
  grpc::Status GetUpload(grpc::ServerContext* context, const v1::GetUploadRequest* request,
                         v1::GetUploadResponse* response) override;

 private:
  // Puts an upload together and hands it over.
  absl::StatusOr<SubmapInfo> Receive(const Call& call,
                                     grpc::ServerReader<v1::UploadSubmapRequest>* reader);

  Gate& gate_;
  const uint64_t max_submap_bytes_;
};

}  // namespace isthmus::rpc
