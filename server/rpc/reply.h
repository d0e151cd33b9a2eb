// The end of a call: the status that travels.
#pragma once

#include <absl/status/status.h>
#include <absl/strings/string_view.h>
#include <grpcpp/support/status.h>

#include <cstddef>
#include <string>

#include "api/convert/retry_after.h"
#include "core/plain_text.h"
#include "server/rpc/streams/limits.h"

namespace isthmus::rpc {

// Same codes, same message; a message longer than what fits into a trailer is cut.
inline grpc::Status ToGrpc(const absl::Status& status) {
  // Trailers are limited to 8 KiB; a message may quote what the client sent.
  constexpr size_t kMaxMessage = 1024;
  // absl's codes are gRPC's by design: https://abseil.io/docs/cpp/guides/status-codes
  const auto code = static_cast<grpc::StatusCode>(status.raw_code());
  const std::string message = CutText(status.message(), kMaxMessage);
  // A client that is told when to come again knows that the server said so, not the way to it.
  const bool says_when = !absl::IsUnavailable(status) || convert::RetryAfter(status);
  const absl::Status told = says_when ? status : convert::WithRetryAfter(status, kRetryAfter);
  return grpc::Status(code, message, convert::StatusDetails(told, message));
}

}  // namespace isthmus::rpc
