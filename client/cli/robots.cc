// isthmus robots: every session of every robot.
#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>

#include "client/cli/commands.h"
#include "client/console/exit_code.h"
#include "client/console/json.h"
#include "client/console/tracking_text.h"

namespace isthmus::cli {
namespace {

struct RobotsOptions {
  ServerOptions server;
  bool json = false;
};

void Report(const std::vector<SessionStatus>& sessions) {
  absl::PrintF("%-16s %-16s %-8s %-8s %7s %7s %10s %9s %5s  %-10s %s\n", "robot", "session",
               "sensor", "state", "scans", "submaps", "points", "metres", "ms", "component",
               "tracking");
  for (const SessionStatus& session : sessions) {
    const std::string component =
        session.component ? absl::StrFormat("%d", *session.component) : std::string("not placed");
    // Counts over all segments are shown with the first.
    const bool is_first = session.record.segment <= 1;
    const std::string tracking = is_first
                                     ? CountsText(session.scans) + SegmentAndLossText(session)
                                     : absl::StrFormat("segment %d of %s", session.record.segment,
                                                       session.record.first_segment.value());
    absl::PrintF("%-16s %-16s %-8s %-8s %7s %7d %10d %9s %5s  %-10s %s\n",
                 session.record.robot.value(), session.record.id.value(), session.record.sensor,
                 session.record.state == SessionState::kFinished ? "finished" : "active",
                 is_first ? absl::StrCat(session.last_sequence) : "", session.submap_count,
                 session.point_count, is_first ? absl::StrFormat("%.1f", session.travelled_m) : "",
                 is_first ? absl::StrFormat("%.1f", session.odometry_ms_mean) : "", component,
                 tracking);
  }
}

int Run(const RobotsOptions& options) {
  const auto client = Connect(options.server);
  if (!client.ok()) return FailServer(client.status());
  const auto sessions = (*client)->ListSessions();
  if (!sessions.ok()) return FailServer(sessions.status());
  if (!options.json) {
    Report(*sessions);
    return kOk;
  }
  Json out = Json::array();
  for (const SessionStatus& session : *sessions) out.push_back(ToJson(session));
  Print(out);
  return kOk;
}

}  // namespace

void AddRobots(CLI::App& app, Action& action) {
  auto options = std::make_shared<RobotsOptions>();
  CLI::App* command = app.add_subcommand("robots", "Every session of every robot");
  AddServerOptions(*command, options->server);
  command->add_flag("--json", options->json, "As JSON");
  command->callback([options, &action] { action = [options] { return Run(*options); }; });
}

}  // namespace isthmus::cli
