#include <absl/strings/str_cat.h>
#include <absl/strings/str_join.h>

#include <algorithm>
#include <limits>
#include <string>

#include "storage/event_log.h"
#include "storage/sql/rows.h"

namespace isthmus::storage {
namespace {

constexpr char kEventColumns[] =
    "number, time_ns, kind, who, peer, request_id, robot, session, text";

Event ReadEvent(const Statement& row) {
  Event event;
  event.number = row.Uint(0);
  event.time_ns = row.Int(1);
  event.kind = ParseEventKind(row.Text(2));
  event.actor = {row.Text(3), row.Text(4), row.Text(5)};
  event.robot = RobotId(row.Text(6));
  event.session = SessionId(row.Text(7));
  event.text = row.Text(8);
  return event;
}

// Names of kinds are this program's own, never a text that somebody sent.
std::string KindsOf(const EventQuery& query) {
  if (query.kinds.empty()) return "";
  const auto name = [](std::string* out, EventKind kind) {
    absl::StrAppend(out, "'", ToString(kind), "'");
  };
  return absl::StrCat(" AND kind IN (", absl::StrJoin(query.kinds, ", ", name), ")");
}

absl::StatusOr<std::vector<Event>> Select(Connection& database, const EventQuery& query) {
  constexpr int64_t kAll = std::numeric_limits<int64_t>::max();
  const auto bounded = [](uint64_t number) {
    return static_cast<int64_t>(std::min(number, static_cast<uint64_t>(kAll)));
  };
  Statement rows = database.Prepare(
      absl::StrCat("SELECT ", kEventColumns,
                   " FROM events WHERE number > ? AND time_ns >= ? AND (? = '' OR robot = "
                   "?)",
                   KindsOf(query), " ORDER BY number ", query.after ? "ASC" : "DESC", " LIMIT ?"));
  rows.Bind(bounded(query.after.value_or(0)))
      .Bind(query.since_ns)
      .Bind(query.robot.value())
      .Bind(query.robot.value())
      .Bind(bounded(query.limit));
  auto events = rows.ReadAll(ReadEvent);
  if (events.ok() && !query.after) std::reverse(events->begin(), events->end());
  return events;
}

}  // namespace

absl::Status AddEvents(Connection& database, const std::vector<Event>& events) {
  if (events.empty()) return absl::OkStatus();
  // One more than the greatest, and not a database's own count, which may leave gaps: the newest
  // never goes.
  Statement insert = database.Prepare(
      "INSERT INTO events (number, time_ns, kind, who, peer, request_id, robot, session, text) "
      "VALUES ((SELECT coalesce(max(number), 0) + 1 FROM events), ?, ?, ?, ?, ?, ?, ?, ?)");
  for (const Event& event : events) {
    const absl::Status status = insert.Bind(event.time_ns)
                                    .Bind(std::string(ToString(event.kind)))
                                    .Bind(event.actor.who)
                                    .Bind(event.actor.from)
                                    .Bind(event.actor.request_id)
                                    .Bind(event.robot.value())
                                    .Bind(event.session.value())
                                    .Bind(event.text)
                                    .Run();
    if (!status.ok()) return status;
  }
  return database.Prepare("DELETE FROM events WHERE number <= (SELECT max(number) FROM events) - ?")
      .Bind(static_cast<int64_t>(kEventsKept))
      .Run();
}

absl::StatusOr<EventPage> SelectEvents(Connection& database, const EventQuery& query) {
  const auto newest = database.ReadNumber("SELECT coalesce(max(number), 0) FROM events");
  if (!newest.ok()) return newest.status();
  const auto first = database.ReadNumber("SELECT coalesce(min(number), 1) FROM events");
  if (!first.ok()) return first.status();
  auto events = Select(database, query);
  if (!events.ok()) return events.status();
  return MakeEventPage(query, *std::move(events), static_cast<uint64_t>(*first),
                       static_cast<uint64_t>(*newest));
}

}  // namespace isthmus::storage
