// The event log, for those who run the server. What each method returns and fails with is said in
// api/isthmus/v1/event_service.proto.
#pragma once

#include <absl/status/status.h>
#include <grpcpp/server_context.h>
#include <grpcpp/support/byte_buffer.h>
#include <grpcpp/support/server_callback.h>
#include <grpcpp/support/status.h>
#include <grpcpp/support/sync_stream.h>

#include <cstdint>

#include "isthmus/v1/event_service.grpc.pb.h"
#include "server/rpc/gate.h"
#include "server/rpc/streams/stream_host.h"

namespace isthmus::rpc {

// A client can watch without end: that holds no thread.
using EventServiceBase =
    v1::EventService::WithRawCallbackMethod_WatchEvents<v1::EventService::Service>;

// Thread safe. Whatever it is given must outlive it.
class EventService final : public EventServiceBase {
 public:
  EventService(Gate* gate, StreamHost* host) : gate_(*gate), host_(*host) {}

  grpc::Status ListEvents(grpc::ServerContext* context, const v1::ListEventsRequest* request,
                          grpc::ServerWriter<v1::ListEventsResponse>* writer) override;
  grpc::ServerWriteReactor<grpc::ByteBuffer>* WatchEvents(grpc::CallbackServerContext* context,
                                                          const grpc::ByteBuffer* request) override;

 private:
  Gate& gate_;
  StreamHost& host_;
};

// OutOfRange for a number that no event of this log has had yet.
absl::Status CheckAfter(uint64_t after, uint64_t newest);

}  // namespace isthmus::rpc
