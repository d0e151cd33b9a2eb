// isthmus log: what happened at a site, and who did it.
#include <absl/strings/ascii.h>
#include <absl/strings/numbers.h>
#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>
#include <absl/strings/str_join.h>
#include <absl/time/clock.h>
#include <absl/time/time.h>

#include <cstdio>
#include <optional>
#include <string>
#include <vector>

#include "api/convert/event.h"
#include "client/console/age.h"
#include "client/console/command.h"
#include "client/console/exit_code.h"
#include "client/console/json.h"
#include "client/console/numbers.h"
#include "client/console/say.h"
#include "core/plain_text.h"
#include "core/records/event.h"

namespace isthmus::cli {
namespace {

constexpr int kDefaultLimit = 20;
constexpr size_t kAtATime = 10'000;  // The most that a server sends.
constexpr size_t kMaxLine = 4 * kMaxEventText;

struct LogOptions {
  ServerOptions server;
  std::string since, robot;
  std::vector<std::string> kinds;
  int limit = 0;  // 0: not given.
  bool follow = false, json = false;
};

std::string TimeOf(const Event& event) {
  return absl::FormatTime("%Y-%m-%dT%H:%M:%SZ", absl::FromUnixNanos(event.time_ns),
                          absl::UTCTimeZone());
}

// One line that leaves the terminal alone, whatever it quotes.
std::string EventLine(const Event& event) {
  std::vector<std::string> by;
  if (!event.actor.who.empty()) by.push_back("by " + event.actor.who);
  if (!event.actor.from.empty()) by.push_back("from " + event.actor.from);
  if (!event.actor.request_id.empty()) by.push_back("request " + event.actor.request_id);
  const std::string who = by.empty() ? "" : absl::StrCat(" (", absl::StrJoin(by, ", "), ")");
  return isthmus::LineOf(absl::StrFormat("#%d %s %-16s %s%s", event.number, TimeOf(event),
                                         ToString(event.kind), event.text, who),
                         kMaxLine);
}

// "#N", a span back from now, a day, or a time of RFC 3339.
absl::Status ParseSince(const std::string& text, EventQuery* query) {
  uint64_t number = 0;
  if (text.starts_with('#') && absl::SimpleAtoi(text.substr(1), &number) && number > 0) {
    query->after = number - 1;
    return absl::OkStatus();
  }
  query->after = 0;
  if (const auto moment = ParseMoment(text)) {
    query->since_ns = absl::ToUnixNanos(*moment);
  } else {
    return absl::InvalidArgumentError(
        absl::StrCat("--since \"", text,
                     "\" is neither a span (45m, 12h, 30d, 2w), a day (2026-05-01), a time "
                     "(2026-05-01T12:00:00Z) nor a number (#120)"));
  }
  return absl::OkStatus();
}

absl::StatusOr<EventQuery> QueryOf(const LogOptions& options) {
  EventQuery query;
  query.robot = RobotId(options.robot);
  query.limit = static_cast<size_t>(options.limit > 0 ? options.limit : kDefaultLimit);
  for (const std::string& name : options.kinds) {
    query.kinds.push_back(ParseEventKind(absl::AsciiStrToUpper(name)));
    if (query.kinds.back() != EventKind::kUnknown) continue;
    const auto add = [](std::string* out, EventKind kind) { absl::StrAppend(out, ToString(kind)); };
    return absl::InvalidArgumentError(absl::StrCat("there is no kind of event \"", name,
                                                   "\"; there are ",
                                                   absl::StrJoin(AllEventKinds(), ", ", add)));
  }
  if (options.since.empty()) return query;
  if (absl::Status status = ParseSince(options.since, &query); !status.ok()) return status;
  return query;
}

// Prints as events come, or keeps them for one document.
class Printer {
 public:
  explicit Printer(const LogOptions& options) : options_(options) {}

  void Take(const EventPage& page) {
    if (page.after > 0 && page.first_kept > page.after + 1) {
      Warn("isthmus: events #%d to #%d are no longer stored\n", page.after + 1,
           page.first_kept - 1);
    }
    for (const Event& event : page.events) {
      if (!options_.json) {
        Say("%s\n", EventLine(event));
      } else if (options_.follow) {
        PrintLine(ToJson(convert::ToMessage(event)));
      } else {
        *response_.add_events() = convert::ToMessage(event);
      }
    }
    std::fflush(stdout);
  }
  void Finish(const EventPage& last) {
    if (!options_.json || options_.follow) return;
    response_.set_up_to(last.up_to);
    response_.set_first_kept(last.first_kept);
    response_.set_newest(last.newest);
    Print(ToJson(response_));
  }

 private:
  const LogOptions& options_;
  v1::ListEventsResponse response_;
};

// Shows what is in the log, and returns the page that ends it.
absl::StatusOr<EventPage> ShowPast(const LogOptions& options, EventQuery query,
                                   client::Client& client, Printer& printer) {
  const bool all = query.after && options.limit == 0;
  if (all) query.limit = kAtATime;
  while (true) {
    auto page = client.ListEvents(query);
    if (!page.ok()) return page.status();
    if (query.after) page->after = *query.after;
    printer.Take(*page);
    if (!all || page->up_to >= page->newest) return page;
    query.after = page->up_to;
  }
}

int FollowLog(EventQuery query, client::Client& client, Printer& printer) {
  const auto take = [&](const EventPage& page) {
    printer.Take(page);
    query.after = page.up_to;
    return true;
  };
  while (true) {
    const absl::Status status = client.WatchEvents(query, take);
    if (!absl::IsUnavailable(status)) return FailServer(status);
    Warn("isthmus: %s; trying again\n", isthmus::LineOf(status.message(), kMaxLine));
  }
}

int RunLog(const LogOptions& options) {
  const auto query = QueryOf(options);
  if (!query.ok()) return Fail(kUsage, query.status());
  const auto client = Connect(options.server);
  if (!client.ok()) return FailServer(client.status());
  Printer printer(options);
  const auto last = ShowPast(options, *query, **client, printer);
  if (!last.ok()) return FailServer(last.status());
  printer.Finish(*last);
  if (!options.follow) return kOk;
  EventQuery rest = *query;
  rest.after = last->up_to;
  return FollowLog(rest, **client, printer);
}

}  // namespace

void AddLog(CLI::App& app, Action& action) {
  auto options = std::make_shared<LogOptions>();
  CLI::App* command =
      app.add_subcommand("log", "The events of a site and who caused them, the newest last");
  AddServerOptions(*command, options->server);
  command->add_flag("--follow,-f", options->follow, "Continue with new events until Ctrl-C");
  command->add_option(
      "--since", options->since,
      "Events since then: 45m, 12h, 30d, 2w, a day, a time, or #NUMBER of an event");
  command->add_option("--kind", options->kinds,
                      "Only events of this kind (ROBOT_LOST); may be repeated");
  command->add_option("--robot", options->robot, "Only events of this robot");
  command
      ->add_option("--limit", options->limit,
                   "At most this many events; without it 20, with --since all")
      ->check(NotNegative())
      ->check(CLI::Range(1, static_cast<int>(kAtATime)));
  command->add_flag("--json", options->json, "As JSON; with --follow one object per line");
  command->callback([options, &action] { action = [options] { return RunLog(*options); }; });
}

}  // namespace isthmus::cli
