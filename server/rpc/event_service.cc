// The event log, for those who run the server. What each method returns and fails with is said in
// api/isthmus/v1/event_service.proto.
#include <algorithm>

#include "api/convert/event.h"
#include "isthmus/v1/event_service.grpc.pb.h"
#include "server/rpc/event_stream.h"
#include "server/rpc/responses.h"
#include "server/rpc/services.h"

namespace isthmus::rpc {
namespace {

constexpr size_t kMaxEvents = 10'000;  // As the API says.

// A client can watch without end: that holds no thread.
using EventServiceBase =
    v1::EventService::WithRawCallbackMethod_WatchEvents<v1::EventService::Service>;

class EventService final : public EventServiceBase {
 public:
  explicit EventService(const ServiceParts& parts) : gate_(parts.gate), host_(parts.host) {}

  grpc::Status ListEvents(grpc::ServerContext* context, const v1::ListEventsRequest* request,
                          grpc::ServerWriter<v1::ListEventsResponse>* writer) override {
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

  grpc::ServerWriteReactor<grpc::ByteBuffer>* WatchEvents(
      grpc::CallbackServerContext* context, const grpc::ByteBuffer* request) override {
    return EventReactorBase::Begin<EventReactor>(&host_, context, request);
  }

 private:
  Gate& gate_;
  StreamHost& host_;
};

}  // namespace

std::unique_ptr<grpc::Service> MakeEventService(const ServiceParts& parts) {
  return std::make_unique<EventService>(parts);
}

}  // namespace isthmus::rpc
