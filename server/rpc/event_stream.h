// EventService.WatchEvents; see api/isthmus/v1/event_service.proto.
#pragma once

#include <absl/status/status.h>
#include <grpcpp/support/byte_buffer.h>
#include <grpcpp/support/server_callback.h>

#include <atomic>
#include <cstdint>
#include <optional>

#include "core/records/event.h"
#include "server/rpc/streams/stream_reactor.h"
#include "server/rpc/streams/watch_base.h"

namespace isthmus::rpc {

// OutOfRange for a number that no event of this log has had yet.
absl::Status CheckAfter(uint64_t after, uint64_t newest);

using EventReactorBase = StreamReactor<WatchBase>;

// Holds one response at most, and no events that wait: they are read from the log by their numbers
// once the response before is written. While nothing happens it holds no thread.
class EventReactor final : public EventReactorBase {
 public:
  EventReactor(StreamHost* host, grpc::CallbackServerContext* context,
               const grpc::ByteBuffer* request)
      : EventReactorBase(host, &host->watches, context, "WatchEvents") {
    SetRequest(*request);
  }

  void OnWriteDone(bool ok) override;

 private:
  void OnMessage(grpc::ByteBuffer message) override;
  void OnReadsDone() override {}
  void OnEnd() override;

  absl::Status BeginWatch(grpc::ByteBuffer* message);
  // Sends what is new, if anything is or nothing was sent yet.
  void SendNext();

  EventQuery query_;  // Its `after` goes along.
  std::optional<uint64_t> handle_;
  std::atomic<bool> is_woken_ = false;  // SendNext is on its way.
  bool is_writing_ = false, has_written_ = false;
  grpc::ByteBuffer response_;
};

}  // namespace isthmus::rpc
