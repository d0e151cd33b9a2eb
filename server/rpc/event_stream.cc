#include "server/rpc/event_stream.h"

#include <absl/strings/str_cat.h>

#include "api/convert/event.h"
#include "isthmus/v1/event_service.pb.h"
#include "server/rpc/streams/messages.h"

namespace isthmus::rpc {

absl::Status CheckAfter(uint64_t after, uint64_t newest) {
  if (after <= newest) return absl::OkStatus();
  return absl::OutOfRangeError(absl::StrCat("the newest event of this log has number ", newest,
                                            ", not ", after,
                                            " or more: it is another log; begin at 0"));
}

absl::Status EventReactor::BeginWatch(grpc::ByteBuffer* message) {
  v1::WatchEventsRequest request;
  if (absl::Status status = ReadMessage(message, &request); !status.ok()) return status;
  auto query = convert::FromMessage(request);
  if (!query.ok()) return query.status();
  query_ = *std::move(query);
  query_.limit = kEventsPerResponse;
  // Before the log is looked at, so that nothing is missed in between.
  const auto wake = [this, weak = weak_from_this()] {
    const auto self = weak.lock();
    if (self == nullptr || is_woken_.exchange(true)) return;
    Post([this] {
      is_woken_ = false;
      SendNext();
    });
  };
  handle_ = call().pipeline().events().OnStored(wake);
  const auto log = call().pipeline().events().List({.limit = 0});
  if (!log.ok()) return log.status();
  if (!query_.after) query_.after = log->newest;
  return CheckAfter(*query_.after, log->newest);
}

void EventReactor::OnMessage(grpc::ByteBuffer message) {
  if (absl::Status status = BeginWatch(&message); !status.ok()) return End(status);
  SendNext();
}

void EventReactor::SendNext() {
  if (is_writing_ || ended()) return;
  const auto page = call().pipeline().events().List(query_);
  if (!page.ok()) return End(page.status());
  v1::WatchEventsResponse response;
  response.set_after(*query_.after);
  response.set_up_to(page->up_to);
  response.set_first_kept(page->first_kept);
  query_.after = page->up_to;
  if (page->events.empty() && has_written_) return;
  for (const Event& event : page->events) *response.add_events() = convert::ToMessage(event);
  is_writing_ = has_written_ = true;
  response_ = ToBytes(response);
  StartWrite(&response_);
}

void EventReactor::OnWriteDone(bool ok) {
  Post([this, ok] {
    is_writing_ = false;
    if (!ok) return End(absl::CancelledError("the client went away"));
    response_.Clear();
    SendNext();
  });
}

void EventReactor::OnEnd() {
  if (handle_) call().pipeline().events().Forget(*handle_);
}

}  // namespace isthmus::rpc
