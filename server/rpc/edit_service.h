// Changes of the map by hand. What each method returns and fails with is said in
// api/isthmus/v1/edit_service.proto.
#pragma once

#include <grpcpp/server_context.h>
#include <grpcpp/support/status.h>

#include <utility>

#include "isthmus/v1/edit_service.grpc.pb.h"
#include "server/pipeline.h"
#include "server/rpc/reply.h"
#include "server/rpc/scans/scan_streams.h"
#include "server/rpc/upload_staging.h"

namespace isthmus::rpc {

// Thread safe. Whatever it is given must outlive it; streams and staging are of the sessions that
// it deletes.
class EditService final : public v1::EditService::Service {
 public:
  EditService(server::Pipeline* pipeline, ScanStreams* streams, UploadStaging* staging, Reply reply)
      : pipeline_(*pipeline), streams_(*streams), staging_(*staging), reply_(std::move(reply)) {}

  grpc::Status DecideMatch(grpc::ServerContext* context, const v1::DecideMatchRequest* request,
                           v1::DecideMatchResponse* response) override;
  grpc::Status DecideLoop(grpc::ServerContext* context, const v1::DecideLoopRequest* request,
                          v1::DecideLoopResponse* response) override;
  grpc::Status PutAnchor(grpc::ServerContext* context, const v1::PutAnchorRequest* request,
                         v1::PutAnchorResponse* response) override;
  grpc::Status DeleteAnchor(grpc::ServerContext* context, const v1::DeleteAnchorRequest* request,
                            v1::DeleteAnchorResponse* response) override;
  grpc::Status SetDatum(grpc::ServerContext* context, const v1::SetDatumRequest* request,
                        v1::SetDatumResponse* response) override;
  grpc::Status UndoRevision(grpc::ServerContext* context, const v1::UndoRevisionRequest* request,
                            v1::UndoRevisionResponse* response) override;
  grpc::Status DeleteSession(grpc::ServerContext* context, const v1::DeleteSessionRequest* request,
                             v1::DeleteSessionResponse* response) override;

 private:
  // What the request means; of a robot, its newest session's.
  absl::StatusOr<SubmapId> AnchoredSubmap(const v1::PutAnchorRequest& request);
  absl::StatusOr<SubmapId> NewestSubmap(const RobotId& robot);

  server::Pipeline& pipeline_;
  ScanStreams& streams_;
  UploadStaging& staging_;
  const Reply reply_;
};

}  // namespace isthmus::rpc
