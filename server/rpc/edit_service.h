// Changes of the map by hand. What each method returns and fails with is said in
// api/isthmus/v1/edit_service.proto.
#pragma once

#include <grpcpp/server_context.h>
#include <grpcpp/support/status.h>

#include "isthmus/v1/edit_service.grpc.pb.h"
#include "server/rpc/gate.h"

namespace isthmus::rpc {

// Thread safe. The gate must outlive it.
class EditService final : public v1::EditService::Service {
 public:
  explicit EditService(Gate* gate) : gate_(*gate) {}

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
  Gate& gate_;
};

}  // namespace isthmus::rpc
