// A call that failed, as the server's log has it.
#pragma once

#include <absl/status/status.h>

#include <functional>
#include <string>

namespace isthmus::rpc {

struct FailedCall {
  std::string rpc;  // "CreateSession".
  absl::Status status;
  std::string peer;         // As gRPC names it.
  std::string request_id;   // Empty where the client gave none and the call was not let in.
  std::string token, site;  // Empty where it was not let in; the token's name.
};

// Told of every call that ends with an error; may be null.
using OnFailedCall = std::function<void(const FailedCall& call)>;

}  // namespace isthmus::rpc
