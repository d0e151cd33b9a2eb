// The end of a call, as the server's log and its metrics have it.
#pragma once

#include <absl/status/status.h>

#include <functional>
#include <string>

namespace isthmus::rpc {

struct FailedCall {
  std::string rpc = {};  // "CreateSession".
  absl::Status status = {};
  std::string peer = {};        // As gRPC names it.
  std::string request_id = {};  // Empty where the client gave none and the call was not let in.
  std::string token = {};       // Its name; empty where none, or none that holds, was sent.
  std::string site = {};        // Empty where it was not let in.
};

// Told of every call that ends with an error; may be null.
using OnFailedCall = std::function<void(const FailedCall& call)>;
// Told of every call that ends, let in or not, and how long it took; may be null.
using OnEndedCall =
    std::function<void(const std::string& rpc, absl::StatusCode code, double seconds)>;

}  // namespace isthmus::rpc
