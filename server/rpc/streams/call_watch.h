// The watch over what is sent to clients: none may hold a call by not reading.
#pragma once

#include <grpcpp/support/server_interceptor.h>

#include <chrono>

#include "server/rpc/streams/watchdog.h"

namespace isthmus::rpc {

// Cancels a call when a message to its client, or its end, does not leave for so long; whoever
// waits to send it is told that the client is gone. Tells refused callers when to come again, in
// the trailer `retry-after-ms`. For every method of the server. Thread safe.
class CallWatchFactory final : public grpc::experimental::ServerInterceptorFactoryInterface {
 public:
  // The watchdog must outlive all calls.
  CallWatchFactory(Watchdog* watchdog, std::chrono::milliseconds progress)
      : watchdog_(*watchdog), progress_(progress) {}

  grpc::experimental::Interceptor* CreateServerInterceptor(
      grpc::experimental::ServerRpcInfo* info) override;

 private:
  Watchdog& watchdog_;
  const std::chrono::milliseconds progress_;
};

}  // namespace isthmus::rpc
