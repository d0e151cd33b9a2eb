// The end of a call: the status that travels.
#pragma once

#include <absl/status/status.h>
#include <absl/strings/cord.h>
#include <absl/strings/string_view.h>
#include <grpcpp/support/status.h>

#include <cstddef>
#include <string>
#include <utility>

#include "api/convert/retry_after.h"
#include "core/plain_text.h"
#include "server/rpc/streams/limits.h"

namespace isthmus::rpc {

// Same code, same message; a message longer than what fits into a trailer is cut. Unavailable says
// when to come again.
inline absl::Status ToldStatus(const absl::Status& status) {
  // Trailers are limited to 8 KiB; a message may quote what the client sent.
  constexpr size_t kMaxMessage = 1024;
  absl::Status told(static_cast<absl::StatusCode>(status.raw_code()),
                    CutText(status.message(), kMaxMessage));
  status.ForEachPayload(
      [&told](absl::string_view url, const absl::Cord& payload) { told.SetPayload(url, payload); });
  // A client that is told when to come again knows that the server said so, not the way to it.
  const bool says_when = !absl::IsUnavailable(status) || convert::RetryAfter(status);
  return says_when ? told : convert::WithRetryAfter(std::move(told), kRetryAfter);
}

// The same status, as gRPC sends it.
inline grpc::Status ToGrpc(const absl::Status& status) {
  const std::string message(status.message());
  // absl's codes are gRPC's by design: https://abseil.io/docs/cpp/guides/status-codes
  return grpc::Status(static_cast<grpc::StatusCode>(status.raw_code()), message,
                      convert::StatusDetails(status, message));
}

}  // namespace isthmus::rpc
