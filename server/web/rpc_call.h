// One call of a service of this server, through the channel within the process.
#pragma once

#include <absl/status/status.h>
#include <absl/strings/string_view.h>
#include <grpcpp/channel.h>
#include <grpcpp/client_context.h>
#include <grpcpp/completion_queue.h>
#include <grpcpp/generic/generic_stub.h>

#include <chrono>
#include <functional>
#include <memory>
#include <string>

#include "server/http/exchange.h"

namespace isthmus::web {

// With one request and any number of answers, all as bytes. Not thread safe.
class RpcCall {
 public:
  enum class Next { kMessage, kNothingYet, kEnd };

  struct Request {
    std::string method = {};    // "/isthmus.v1.MapService/GetMapInfo".
    http::Fields headers = {};  // In lower case.
    std::string message = {};
    std::chrono::milliseconds deadline{0};  // 0: none.
    // Asked while it waits; a call nobody waits for is cancelled. Never null.
    std::function<bool()> gone = [] { return false; };
  };
  // A request of the method ("MapService/GetMapInfo") in the name of the caller over HTTP, while it
  // waits for the answer.
  static Request For(const http::Request& request, absl::string_view method, std::string message);

  RpcCall(const std::shared_ptr<grpc::Channel>& channel, Request request);
  ~RpcCall();  // Cancels the call under way.
  RpcCall(const RpcCall&) = delete;
  RpcCall& operator=(const RpcCall&) = delete;

  // Waits so long for the next answer, and longer if need be where `patience` is zero.
  Next Take(std::chrono::milliseconds patience, std::string* message);
  // Its end, once there is none.
  const absl::Status& status() const { return status_; }

 private:
  // False: it is over.
  bool WaitForTag();
  bool WaitForTag(std::chrono::milliseconds patience, bool* has_come);
  void Finish();

  const Request request_;
  grpc::GenericStub stub_;
  grpc::ClientContext context_;
  grpc::CompletionQueue queue_;
  std::unique_ptr<grpc::GenericClientAsyncReaderWriter> call_;
  grpc::ByteBuffer buffer_;
  bool is_reading_ = false, is_over_ = false;
  absl::Status status_;
};

}  // namespace isthmus::web
