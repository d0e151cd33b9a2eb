#include "client/console/top_frame.h"

#include <absl/strings/ascii.h>
#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>

#include <algorithm>
#include <utility>

#include "client/console/console.h"
#include "client/console/localising_text.h"
#include "client/console/say.h"
#include "client/console/server_figures.h"

namespace isthmus::cli {
namespace {

// The status of the same run of the server some time earlier; null if there is none.
const ServerStatus* Earlier(const TopView& view) {
  const bool is_earlier = view.status && view.before &&
                          view.before->started_ns == view.status->started_ns &&
                          view.before->uptime_s < view.status->uptime_s;
  return is_earlier ? &*view.before : nullptr;
}

std::string CpuText(const ServerStatus& now, const ServerStatus* before) {
  if (before == nullptr) return "-";
  return absl::StrFormat("%.0f %%", 100 * (now.process.cpu_s - before->process.cpu_s) /
                                        (now.uptime_s - before->uptime_s));
}

// Puts items side by side, into as many lines as they need.
void AddItems(const std::vector<std::string>& items, size_t columns,
              std::vector<std::string>* lines) {
  constexpr char kBetween[] = "   ";
  std::string line;
  for (const std::string& item : items) {
    if (!line.empty() && line.size() + sizeof(kBetween) - 1 + item.size() > columns) {
      lines->push_back(std::exchange(line, {}));
    }
    absl::StrAppend(&line, line.empty() ? "" : kBetween, item);
  }
  lines->push_back(line);
}

std::string DiskText(const DiskLoad& disk) {
  if (disk.total_bytes == 0) return "disk none";
  return absl::StrCat("disk ", HumanBytes(disk.used_bytes()), " used, ",
                      HumanBytes(disk.free_bytes), " free");
}

std::string MatchingText(const MatchingLoad& matching) {
  std::string workers =
      matching.workers == 0 ? "" : absl::StrCat(", ", matching.workers, " workers");
  if (matching.jobs_set_aside > 0) {
    absl::StrAppend(&workers, ", ", matching.jobs_set_aside, " jobs set aside");
  }
  if (matching.is_idle) return absl::StrCat("matching idle", workers);
  return absl::StrCat("matching ", matching.submaps, " submaps, ", matching.pairs + matching.jobs,
                      " pairs", workers);
}

std::string CompositionText(const ServerLoad& load) {
  if (load.map_is_loading) return "composition after the start";
  return absl::StrFormat("composition %.1f ms", load.composition_ms);
}

void AddHeader(const TopView& view, size_t columns, std::vector<std::string>* lines) {
  if (!view.status) return;
  const ServerStatus& status = *view.status;
  const ProcessUse& process = status.process;
  const RunningCallCounts& calls = status.calls;
  const ServerLoad& load = status.load;
  AddItems({Printable(absl::StrCat("isthmus ", status.version, " at ", view.address, ", site ",
                                   status.site)),
            absl::StrCat("up ", UpTimeText(status.uptime_s)),
            absl::StrCat("revision ", load.revision, ", ", load.submaps, " submaps")},
           columns, lines);
  AddItems({absl::StrCat("cpu ", CpuText(status, Earlier(view))),
            absl::StrCat("memory ", HumanBytes(process.resident_bytes)),
            absl::StrCat("threads ", process.threads),
            absl::StrCat("files ", process.open_files, " of ", process.open_files_limit),
            absl::StrCat("calls ", calls.streams, " streams, ",
                         calls.queries + calls.exports + calls.lists + calls.others, " others")},
           columns, lines);
  AddItems({DiskText(load.disk),
            absl::StrCat("queues ", load.waiting_scans, " scans, ", HumanBytes(load.waiting_bytes)),
            MatchingText(load.matching), CompositionText(load)},
           columns, lines);
}

void AddTroubles(const TopView& view, std::vector<std::string>* lines) {
  if (!view.problem.empty()) {
    lines->push_back(absl::StrCat("CONNECTION LOST, trying again: ", view.problem));
  }
  if (!view.status) return;
  for (const DegradedService& degraded : view.status->degraded) {
    lines->push_back(absl::StrCat("DEGRADED ", degraded.service, ": ", degraded.why));
  }
}

struct Column {
  const char* title;
  int rank;  // The highest is left out first.
  std::vector<std::string> cells = {};
  size_t width = 0;
};

std::string StateText(const SessionLoad& session) {
  const std::string state = ToString(session.tracking);
  if (state.empty()) return "-";
  return session.tracking == Tracking::kLost ? absl::AsciiStrToUpper(state) : state;
}

std::string RateText(const SessionLoad& session, const TopView& view) {
  const ServerStatus* before = Earlier(view);
  if (before == nullptr) return "-";
  for (const SessionLoad& old : before->load.sessions) {
    if (old.session != session.session || old.received_sequence > session.received_sequence) {
      continue;
    }
    return absl::StrFormat("%.1f",
                           static_cast<double>(session.received_sequence - old.received_sequence) /
                               (view.status->uptime_s - before->uptime_s));
  }
  return "-";
}

std::string LagText(const Lag& lag) {
  if (lag.scans == 0) return "0";
  return lag.seconds < 0 ? absl::StrCat(lag.scans)
                         : absl::StrFormat("%d, %.1f s", lag.scans, lag.seconds);
}

std::string LostText(const SessionLoad& session) {
  if (session.lost_since_ns == 0) return "-";
  return absl::StrFormat("%.1f", 1e-9 * static_cast<double>(session.lost_since_ns));
}

std::string RateText(const RobotPlace& place, const TopView& view) {
  const ServerStatus* before = Earlier(view);
  if (before == nullptr) return "-";
  for (const RobotPlace& old : before->load.localising) {
    if (old.robot != place.robot || old.localising->since_ns != place.localising->since_ns)
      continue;
    return absl::StrFormat("%.1f",
                           static_cast<double>(place.localising->scans - old.localising->scans) /
                               (view.status->uptime_s - before->uptime_s));
  }
  return "-";
}

// Sessions, then robots that are localised: these have no queue, and nothing of them is kept.
std::vector<std::vector<std::string>> Rows(const TopView& view) {
  std::vector<std::vector<std::string>> rows;
  const ServerLoad& load = view.status->load;
  for (const SessionLoad& session : load.sessions) {
    rows.push_back(
        {Printable(session.session.value()), StateText(session), RateText(session, view),
         session.waiting_scans == 0
             ? std::string("0")
             : absl::StrCat(session.waiting_scans, ", ", HumanBytes(session.waiting_bytes)),
         LagText(AckLag(session, load.now_ns)), LagText(DurableLag(session, load.now_ns)),
         HumanBytes(session.map_bytes + session.scan_bytes), LostText(session)});
  }
  for (const RobotPlace& place : load.localising) {
    rows.push_back({Printable(absl::StrCat(NameOf(place), ", localised")),
                    place.localising->scans == 0 ? "-" : ToString(place.localising->state),
                    RateText(place, view), "-",
                    place.lag_ms > 0 ? absl::StrFormat("%.1f s", place.lag_ms / 1000) : "0", "-",
                    "-", "-"});
  }
  return rows;
}

std::vector<Column> FillColumns(const TopView& view) {
  std::vector<Column> columns = {{"SESSION", 0}, {"STATE", 1},     {"SCANS/S", 2},
                                 {"QUEUE", 3},   {"ACK LAG", 4},   {"DURABLE LAG", 5},
                                 {"STORED", 6},  {"LOST SINCE", 7}};
  for (std::vector<std::string>& cells : Rows(view)) {
    for (size_t i = 0; i < columns.size(); ++i) columns[i].cells.push_back(std::move(cells[i]));
  }
  for (Column& column : columns) {
    column.width = std::string(column.title).size();
    for (const std::string& cell : column.cells) {
      column.width = std::max(column.width, cell.size());
    }
  }
  return columns;
}

constexpr size_t kGap = 2;

size_t WidthOf(const std::vector<Column>& columns) {
  size_t width = 0;
  for (const Column& column : columns) width += column.width + kGap;
  return width - kGap;
}

void AddTable(const TopView& view, size_t width, std::vector<std::string>* lines) {
  if (!view.status) return;
  std::vector<Column> columns = FillColumns(view);
  const size_t rows = columns.front().cells.size();
  if (rows == 0) return;
  while (columns.size() > 1 && WidthOf(columns) > width) {
    columns.erase(std::ranges::max_element(columns, {}, &Column::rank));
  }
  lines->emplace_back();
  for (size_t row = 0; row <= rows; ++row) {
    std::string line;
    for (const Column& column : columns) {
      const std::string text = row == 0 ? column.title : column.cells[row - 1];
      if (!line.empty()) line.append(kGap, ' ');
      absl::StrAppendFormat(&line, "%-*s", static_cast<int>(column.width), text);
    }
    lines->push_back(std::string(absl::StripTrailingAsciiWhitespace(line)));
  }
}

}  // namespace

std::vector<std::string> TopLines(const TopView& view, size_t columns) {
  std::vector<std::string> lines;
  AddHeader(view, columns, &lines);
  AddTroubles(view, &lines);
  AddTable(view, columns, &lines);
  const bool has_rows =
      view.status && (!view.status->load.sessions.empty() || !view.status->load.localising.empty());
  if (view.status && !has_rows) lines.emplace_back("no open sessions");
  for (std::string& line : lines) line = Printable(line).substr(0, columns);
  return lines;
}

}  // namespace isthmus::cli
