// The end of a call: the status that travels, and who is told of a failure.
#pragma once

#include <absl/status/status.h>
#include <grpcpp/support/status.h>

#include <functional>
#include <string>

namespace isthmus::rpc {

// Same codes, same message; a message longer than what fits into a trailer is cut.
inline grpc::Status ToGrpc(const absl::Status& status) {
  // Trailers are limited to 8 KiB; a message may quote what the client sent.
  constexpr size_t kMaxMessage = 1024;
  // absl's codes are gRPC's by design: https://abseil.io/docs/cpp/guides/status-codes
  const auto code = static_cast<grpc::StatusCode>(status.raw_code());
  return grpc::Status(code, std::string(status.message().substr(0, kMaxMessage)));
}

// Told of every call that ends with an error; may be null.
using OnFailedCall = std::function<void(const std::string& rpc, const absl::Status& status)>;

}  // namespace isthmus::rpc
