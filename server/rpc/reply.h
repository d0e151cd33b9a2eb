// The end of a call: the status that travels, and who is told of a failure.
#pragma once

#include <absl/status/status.h>
#include <absl/strings/string_view.h>
#include <grpcpp/support/status.h>

#include <cstddef>
#include <functional>
#include <string>

#include "api/convert/retry_after.h"

namespace isthmus::rpc {

// At most so many bytes, without half a character at their end (UTF-8).
inline std::string CutText(absl::string_view text, size_t most) {
  if (text.size() <= most) return std::string(text);
  while (most > 0 && (static_cast<unsigned char>(text[most]) & 0xC0) == 0x80) --most;
  return std::string(text.substr(0, most));
}

// Same codes, same message; a message longer than what fits into a trailer is cut.
inline grpc::Status ToGrpc(const absl::Status& status) {
  // Trailers are limited to 8 KiB; a message may quote what the client sent.
  constexpr size_t kMaxMessage = 1024;
  // absl's codes are gRPC's by design: https://abseil.io/docs/cpp/guides/status-codes
  const auto code = static_cast<grpc::StatusCode>(status.raw_code());
  const std::string message = CutText(status.message(), kMaxMessage);
  return grpc::Status(code, message, convert::StatusDetails(status, message));
}

// Told of every call that ends, let in or not, and how long it took; may be null.
using OnEndedCall =
    std::function<void(const std::string& rpc, absl::StatusCode code, double seconds)>;
// Told of every call that ends with an error; may be null.
using OnFailedCall = std::function<void(const std::string& rpc, const absl::Status& status)>;

}  // namespace isthmus::rpc
