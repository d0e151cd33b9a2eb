#include "api/convert/event.h"

#include <absl/strings/str_cat.h>

#include <string>
#include <utility>

#include "core/plain_text.h"

namespace isthmus::convert {
namespace {

// The names are the same in both.
v1::EventKind KindToMessage(EventKind kind) {
  v1::EventKind message = v1::EVENT_KIND_UNSPECIFIED;
  return v1::EventKind_Parse(ToString(kind), &message) ? message : v1::EVENT_KIND_UNSPECIFIED;
}

EventKind KindFromMessage(v1::EventKind kind) { return ParseEventKind(v1::EventKind_Name(kind)); }

template <typename Request>
absl::StatusOr<EventQuery> Wanted(const Request& request) {
  EventQuery query;
  if (request.has_after()) query.after = request.after();
  query.robot = RobotId(request.robot());
  for (const int number : request.kinds()) {
    const EventKind kind = KindFromMessage(static_cast<v1::EventKind>(number));
    if (kind == EventKind::kUnknown) {
      return absl::InvalidArgumentError(
          absl::StrCat("this server has no events of kind ", number, ": ask for those it has"));
    }
    query.kinds.push_back(kind);
  }
  return query;
}

}  // namespace

v1::Event ToMessage(const Event& event) {
  v1::Event message;
  message.set_number(event.number);
  message.set_time_ns(event.time_ns);
  message.set_kind(KindToMessage(event.kind));
  message.set_text(ValidUtf8(event.text));
  message.set_who(event.actor.who);
  message.set_from(event.actor.from);
  message.set_request_id(event.actor.request_id);
  message.set_robot(event.robot.value());
  message.set_session(event.session.value());
  return message;
}

Event FromMessage(const v1::Event& event) {
  Event record;
  record.number = event.number();
  record.time_ns = event.time_ns();
  record.kind = KindFromMessage(event.kind());
  record.actor = {event.who(), event.from(), event.request_id()};
  record.robot = RobotId(event.robot());
  record.session = SessionId(event.session());
  record.text = event.text();
  return record;
}

v1::ListEventsRequest ToMessage(const EventQuery& query) {
  v1::ListEventsRequest request;
  if (query.after) request.set_after(*query.after);
  request.set_since_ns(query.since_ns);
  for (const EventKind kind : query.kinds) request.add_kinds(KindToMessage(kind));
  request.set_robot(query.robot.value());
  request.set_limit(static_cast<uint32_t>(query.limit));
  return request;
}

v1::WatchEventsRequest ToWatchMessage(const EventQuery& query) {
  v1::WatchEventsRequest request;
  if (query.after) request.set_after(*query.after);
  for (const EventKind kind : query.kinds) request.add_kinds(KindToMessage(kind));
  request.set_robot(query.robot.value());
  return request;
}

absl::StatusOr<EventQuery> FromMessage(const v1::ListEventsRequest& request) {
  auto query = Wanted(request);
  if (query.ok()) query->since_ns = request.since_ns();
  if (query.ok() && request.limit() > 0) query->limit = request.limit();
  return query;
}

absl::StatusOr<EventQuery> FromMessage(const v1::WatchEventsRequest& request) {
  return Wanted(request);
}

}  // namespace isthmus::convert
