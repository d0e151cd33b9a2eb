// The part of Client that reads the event log.
#include <utility>

#include "api/convert/event.h"
#include "client/library/client.h"
#include "client/library/link.h"
#include "client/library/list_stream.h"

namespace isthmus::client {

using Stubs = Client::Link::Stubs;

absl::StatusOr<EventPage> Client::ListEvents(const EventQuery& query) {
  const auto open = [&](Stubs& stubs, grpc::ClientContext& context) {
    return stubs.events->ListEvents(&context, convert::ToMessage(query));
  };
  const auto add = [](const v1::ListEventsResponse& part, EventPage& page) {
    page.up_to = part.up_to();
    page.first_kept = part.first_kept();
    page.newest = part.newest();
    for (const v1::Event& event : part.events()) page.events.push_back(convert::FromMessage(event));
  };
  return ReadList<EventPage, v1::ListEventsResponse>(*link_, open, add);
}

absl::Status Client::WatchEvents(EventQuery query, const OnEvents& take) {
  bool goes_on = true;
  // One connection, as long as it lasts.
  const auto watch = [&]() -> absl::Status {
    const std::shared_ptr<Stubs> stubs = link_->Get();
    grpc::ClientContext context;
    link_->Attach(context);
    const auto reader = stubs->events->WatchEvents(&context, convert::ToWatchMessage(query));
    bool has_heard = false;
    for (v1::WatchEventsResponse response; goes_on && reader->Read(&response);) {
      has_heard = true;
      EventPage page;
      page.after = response.after();
      page.up_to = response.up_to();
      page.first_kept = response.first_kept();
      for (const v1::Event& event : response.events()) {
        page.events.push_back(convert::FromMessage(event));
      }
      query.after = page.up_to;
      goes_on = take(page);
    }
    if (!goes_on) context.TryCancel();
    const absl::Status status = ToStatus(reader->Finish());
    if (!goes_on) return absl::OkStatus();
    if (absl::IsUnavailable(status)) link_->Renew(stubs);
    return has_heard && absl::IsUnavailable(status) ? absl::OkStatus() : status;
  };
  absl::Status status;
  while (goes_on && status.ok()) status = link_->Repeat(false, watch);
  return status;
}

}  // namespace isthmus::client
