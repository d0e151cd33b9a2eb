#include "server/rpc/event_service.h"

#include <absl/strings/str_cat.h>

#include <algorithm>

#include "api/convert/event.h"
#include "server/rpc/event_stream.h"
#include "server/rpc/responses.h"

namespace isthmus::rpc {
namespace {

constexpr size_t kMaxEvents = 10'000;  // As the API says.

}  // namespace

absl::Status CheckAfter(uint64_t after, uint64_t newest) {
  if (after <= newest) return absl::OkStatus();
  return absl::OutOfRangeError(absl::StrCat("the newest event of this log has number ", newest,
                                            ", not ", after,
                                            " or more: it is another log; begin at 0"));
}

grpc::Status EventService::ListEvents(grpc::ServerContext* context,
                                      const v1::ListEventsRequest* request,
                                      grpc::ServerWriter<v1::ListEventsResponse>* writer) {
  return gate_.Serve(context, *request, "ListEvents", [&](const Call& call) -> absl::Status {
    auto query = convert::FromMessage(*request);
    if (!query.ok()) return query.status();
    query->limit = std::min(query->limit, kMaxEvents);
    const auto page = call.pipeline().events().List(*query);
    if (!page.ok()) return page.status();
    if (absl::Status status = CheckAfter(query->after.value_or(0), page->newest); !status.ok()) {
      return status;
    }
    v1::ListEventsResponse head;
    head.set_up_to(page->up_to);
    head.set_first_kept(page->first_kept);
    head.set_newest(page->newest);
    ListEmitter<v1::ListEventsResponse> list(call, head, writer);
    for (const Event& event : page->events) {
      list.Add(&v1::ListEventsResponse::mutable_events, convert::ToMessage(event));
    }
    return list.Finish();
  });
}

grpc::ServerWriteReactor<grpc::ByteBuffer>* EventService::WatchEvents(
    grpc::CallbackServerContext* context, const grpc::ByteBuffer* request) {
  return EventReactorBase::Begin<EventReactor>(&host_, context, request);
}

}  // namespace isthmus::rpc
