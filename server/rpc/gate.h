// The one place that every call of every service passes before its handler runs.
#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>
#include <absl/strings/string_view.h>
#include <grpcpp/server_context.h>

#include <atomic>
#include <cstdint>
#include <string>
#include <utility>

#include "core/caught.h"
#include "server/rpc/call.h"
#include "server/rpc/reply.h"

namespace isthmus::rpc {

// A handler that answers in its own thread is run by Serve. A reactor asks Admit first, finishes at
// once where that fails, keeps the Call as long as it lives, and lets every status that it finishes
// with go through End. Thread safe; must outlive its calls.
class Gate {
 public:
  // The site and the limits must outlive the gate; `on_failed_call` may be null.
  Gate(Site* site, CallLimits* limits, OnFailedCall on_failed_call)
      : site_(*site), limits_(*limits), on_failed_call_(std::move(on_failed_call)) {}

  // `rpc` is the method's bare name ("StreamScans"). Unauthenticated or PermissionDenied, with a
  // message that says nothing of what there is. ResourceExhausted beyond a limit of calls.
  absl::StatusOr<Call> Admit(const grpc::ServerContextBase& context, absl::string_view rpc);

  // The status that travels at the end of a call, let in or not; tells of failures.
  grpc::Status End(absl::string_view rpc, const absl::Status& status) const;

  // Answers with the status that `handler(const Call&)` returns. What it throws is the answer to
  // this call alone.
  template <typename Handler>
  grpc::Status Serve(grpc::ServerContextBase* context, const char* rpc, const Handler& handler) {
    return End(rpc, Run(*context, rpc, handler));
  }

 private:
  template <typename Handler>
  absl::Status Run(const grpc::ServerContextBase& context, const char* rpc,
                   const Handler& handler) {
    try {
      const absl::StatusOr<Call> call = Admit(context, rpc);
      return call.ok() ? handler(*call) : call.status();
    } catch (...) {
      return CaughtStatus();
    }
  }

  Site& site_;
  CallLimits& limits_;
  const OnFailedCall on_failed_call_;
  std::atomic<uint64_t> calls_ = 0;
};

}  // namespace isthmus::rpc
