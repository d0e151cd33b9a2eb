// Looking after the server itself. What each method returns and fails with is said in
// api/isthmus/v1/admin_service.proto.
#pragma once

#include <grpcpp/server_context.h>
#include <grpcpp/support/status.h>
#include <grpcpp/support/sync_stream.h>

#include <atomic>
#include <utility>

#include "isthmus/v1/admin_service.grpc.pb.h"
#include "server/pipeline.h"
#include "server/rpc/reply.h"
#include "server/rpc/server.h"

namespace isthmus::rpc {

// Thread safe. The pipeline must outlive it.
class AdminService final : public v1::AdminService::Service {
 public:
  // The source may be null: there are no backups then.
  AdminService(server::Pipeline* pipeline, BackupSource source, Reply reply)
      : pipeline_(*pipeline), source_(std::move(source)), reply_(std::move(reply)) {}

  grpc::Status BackUp(grpc::ServerContext* context, const v1::BackUpRequest* request,
                      grpc::ServerWriter<v1::BackUpResponse>* writer) override;

 private:
  absl::Status SendBackup(grpc::ServerWriter<v1::BackUpResponse>* writer);

  server::Pipeline& pipeline_;
  const BackupSource source_;
  const Reply reply_;
  std::atomic<bool> backing_up_ = false;
};

}  // namespace isthmus::rpc
