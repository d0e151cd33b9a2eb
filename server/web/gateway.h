// Every method of the API over HTTP: POST /rpc/isthmus.v1.SERVICE/METHOD.
#pragma once

#include <absl/strings/string_view.h>
#include <grpcpp/channel.h>

#include <memory>

#include "server/http/exchange.h"
#include "server/web/stream_slots.h"

namespace isthmus::web {

// Calls go through the server's own channel, so that rights, limits, events and the log are those
// of gRPC. A method with many answers is answered by a stream; one that is asked by many messages
// by 501. Thread safe.
class Gateway {
 public:
  // `slots` must outlive it and its answers.
  Gateway(std::shared_ptr<grpc::Channel> channel, StreamSlots* slots)
      : channel_(std::move(channel)), slots_(slots) {}

  // `method`: "isthmus.v1.MapService/GetMapInfo".
  http::Response Answer(const http::Request& request, absl::string_view method) const;

 private:
  const std::shared_ptr<grpc::Channel> channel_;
  StreamSlots* const slots_;
};

}  // namespace isthmus::web
