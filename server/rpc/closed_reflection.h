// Reflection behind the gate: gRPC's own service, which no handler of ours answers.
#pragma once

#include <grpcpp/support/server_interceptor.h>

#include <memory>

#include "server/rpc/gate.h"

namespace isthmus::rpc {

// Calls of reflection that the gate does not let in are cancelled before they are answered; it is
// asked for "ServerReflectionInfo". The gate must outlive the server.
std::unique_ptr<grpc::experimental::ServerInterceptorFactoryInterface> CloseReflection(Gate* gate);

}  // namespace isthmus::rpc
