// Events as messages, and back.
#pragma once

#include <absl/status/statusor.h>

#include "core/records/event.h"
#include "isthmus/v1/event_service.pb.h"

namespace isthmus::convert {

// Bytes of the text that are no UTF-8 become '?'.
v1::Event ToMessage(const Event& event);
Event FromMessage(const v1::Event& event);

v1::ListEventsRequest ToMessage(const EventQuery& query);
// Without limit and time: who watches has none.
v1::WatchEventsRequest ToWatchMessage(const EventQuery& query);

// InvalidArgument for a kind that this program does not know, and which none of its events has.
absl::StatusOr<EventQuery> FromMessage(const v1::ListEventsRequest& request);
// Without limit and time.
absl::StatusOr<EventQuery> FromMessage(const v1::WatchEventsRequest& request);

}  // namespace isthmus::convert
