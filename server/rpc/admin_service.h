// Looking after the server itself. api/isthmus/v1/admin_service.proto says what each method returns
// and fails with.
#pragma once

#include <grpcpp/server_context.h>
#include <grpcpp/support/status.h>
#include <grpcpp/support/sync_stream.h>

#include <cstdint>
#include <string>
#include <utility>

#include "core/clock.h"
#include "core/concurrency/mutex.h"
#include "core/stopwatch.h"
#include "isthmus/v1/admin_service.grpc.pb.h"
#include "server/access/tokens.h"
#include "server/rpc/gate.h"

namespace isthmus::rpc {

// Thread safe. The gate must outlive it, and so must the tokens, which may be null.
class AdminService final : public v1::AdminService::Service {
 public:
  AdminService(Gate* gate, access::Tokens* tokens) : gate_(*gate), tokens_(tokens) {}

  grpc::Status BackUp(grpc::ServerContext* context, const v1::BackUpRequest* request,
                      grpc::ServerWriter<v1::BackUpResponse>* writer) override;
  grpc::Status GetStatus(grpc::ServerContext* context, const v1::GetStatusRequest* request,
                         v1::ServerStatus* response) override;

  // Sets the address at which browsers are served from now on, as ServerStatus has it.
  void TellWebAddress(std::string address) {
    MutexLock lock(&mutex_);
    web_address_ = std::move(address);
  }

 private:
  Gate& gate_;
  access::Tokens* const tokens_;
  const int64_t started_ns_ = Clock::System().NowNs();
  const Stopwatch up_;
  Mutex mutex_;
  std::string web_address_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace isthmus::rpc
