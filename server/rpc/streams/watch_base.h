// A stream that answers one request for as long as its client likes.
#pragma once

#include <grpcpp/support/byte_buffer.h>
#include <grpcpp/support/server_callback.h>

#include <utility>

namespace isthmus::rpc {

// gRPC's reactor of such a stream, for StreamReactor: the request, which has come before the stream
// begins, is its one message.
class WatchBase : public grpc::ServerWriteReactor<grpc::ByteBuffer> {
 public:
  virtual void OnReadDone(bool ok) = 0;

 protected:
  // Before the stream begins.
  void SetRequest(const grpc::ByteBuffer& request) { request_ = request; }

  // There is no second message.
  void StartRead(grpc::ByteBuffer* message) {
    if (is_read_) return;
    is_read_ = true;
    message->Swap(&request_);
    OnReadDone(true);
  }

 private:
  grpc::ByteBuffer request_;
  bool is_read_ = false;
};

}  // namespace isthmus::rpc
