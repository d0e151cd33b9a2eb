// Robots' data on its way in: sessions, scans, finished submaps. What each method returns and fails
// with is said in api/isthmus/v1/session_service.proto.
#pragma once

#include <grpcpp/server_context.h>
#include <grpcpp/support/status.h>
#include <grpcpp/support/sync_stream.h>

#include <cstdint>

#include "isthmus/v1/session_service.grpc.pb.h"
#include "server/pipeline.h"
#include "server/rpc/reply.h"
#include "server/rpc/scans/scan_streams.h"
#include "server/rpc/upload_staging.h"

namespace isthmus::rpc {

// Thread safe. Whatever it is given must outlive it.
class SessionService final : public v1::SessionService::Service {
 public:
  // At most `max_submap_bytes` are taken of an upload, as they travel.
  SessionService(server::Pipeline* pipeline, ScanStreams* streams, UploadStaging* staging,
                 uint64_t max_submap_bytes, Reply reply)
      : pipeline_(*pipeline),
        streams_(*streams),
        staging_(*staging),
        max_submap_bytes_(max_submap_bytes),
        reply_(std::move(reply)) {}

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
  absl::StatusOr<SubmapInfo> Receive(grpc::ServerReader<v1::UploadSubmapRequest>* reader);

  server::Pipeline& pipeline_;
  ScanStreams& streams_;
  UploadStaging& staging_;
  const uint64_t max_submap_bytes_;
  const Reply reply_;
};

}  // namespace isthmus::rpc
