// Readers of the map over HTTP, behind the gate that calls of gRPC pass.
#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>
#include <google/protobuf/message.h>

#include <functional>

#include "server/http/exchange.h"
#include "server/rpc/call.h"
#include "server/rpc/gate.h"

namespace isthmus::web {

// Runs `read` in this thread where the gate lets the request's caller call the method of that bare
// name ("GetTile") with what is `asked`; the status is the gate's, or that of `read`. It has as
// long as a call with one answer: call.Gone() says when its time is over.
absl::Status PassGate(rpc::Gate& gate, const http::Request& request, const char* rpc,
                      const google::protobuf::Message& asked,
                      const std::function<absl::Status(const rpc::Call& call)>& read);

using MapRead = std::function<absl::StatusOr<http::Response>(const rpc::Call& call)>;

// The same, with the response that `read` makes; else with the error.
http::Response ReadMap(rpc::Gate& gate, const http::Request& request, const char* rpc,
                       const google::protobuf::Message& asked, const MapRead& read);

}  // namespace isthmus::web
