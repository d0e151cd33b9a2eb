// Robots that are looked for in the map. What the method returns and fails with is said in
// api/isthmus/v1/localisation_service.proto.
#pragma once

#include <grpcpp/server_context.h>
#include <grpcpp/support/status.h>
#include <grpcpp/support/sync_stream.h>

#include <set>

#include "core/concurrency/mutex.h"
#include "isthmus/v1/localisation_service.grpc.pb.h"
#include "server/rpc/gate.h"

namespace isthmus::rpc {

// Thread safe. The gate must outlive it.
class LocalisationService final : public v1::LocalisationService::Service {
 public:
  explicit LocalisationService(Gate* gate) : gate_(*gate) {}

  grpc::Status Localise(
      grpc::ServerContext* context,
      grpc::ServerReaderWriter<v1::LocaliseResponse, v1::LocaliseRequest>* stream) override;

  // Ends all streams, and those that come: nothing of them has to be kept.
  void StopAll();

 private:
  using Stream = grpc::ServerReaderWriter<v1::LocaliseResponse, v1::LocaliseRequest>;
  absl::Status Serve(const Call& call, Stream* stream);
  bool Enter(grpc::ServerContext* context);
  void Leave(grpc::ServerContext* context);

  Gate& gate_;
  Mutex mutex_;
  std::set<grpc::ServerContext*> streams_ ABSL_GUARDED_BY(mutex_);
  bool stopped_ ABSL_GUARDED_BY(mutex_) = false;
};

}  // namespace isthmus::rpc
