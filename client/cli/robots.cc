// isthmus robots: every session of every robot.
#include <absl/strings/str_format.h>

#include "client/cli/command.h"
#include "client/cli/exit_code.h"
#include "client/cli/json.h"
#include "client/cli/tracking_text.h"

namespace isthmus::cli {
namespace {

struct Options {
  ServerOptions server;
  bool json = false;
};

void Report(const std::vector<client::Session>& sessions) {
  absl::PrintF("%-16s %-16s %-8s %-8s %7s %7s %10s %9s %5s  %-10s %s\n", "robot", "session",
               "sensor", "state", "scans", "submaps", "points", "metres", "ms", "component",
               "tracking");
  for (const client::Session& session : sessions) {
    const std::string component =
        session.component ? absl::StrFormat("%d", *session.component) : std::string("not placed");
    const std::string tracking = session.record.segment > 1
                                     ? absl::StrFormat("segment %d of %s", session.record.segment,
                                                       session.record.first_segment.value())
                                     : CountsText(session.scans) + SegmentAndLossText(session);
    absl::PrintF("%-16s %-16s %-8s %-8s %7d %7d %10d %9.1f %5.1f  %-10s %s\n",
                 session.record.robot.value(), session.record.id.value(), session.record.sensor,
                 session.record.state == SessionState::kFinished ? "finished" : "active",
                 session.last_sequence, session.submap_count, session.point_count,
                 session.travelled_m, session.odometry_ms_mean, component, tracking);
  }
}

int Run(const Options& options) {
  const auto client = Connect(options.server);
  if (!client.ok()) return FailServer(client.status());
  const auto sessions = (*client)->ListSessions();
  if (!sessions.ok()) return FailServer(sessions.status());
  if (!options.json) {
    Report(*sessions);
    return kOk;
  }
  Json out = Json::array();
  for (const client::Session& session : *sessions) out.push_back(ToJson(session));
  Print(out);
  return kOk;
}

}  // namespace

void AddRobots(CLI::App& app, Action& action) {
  auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand("robots", "Every session of every robot");
  AddServerOptions(*command, options->server);
  command->add_flag("--json", options->json, "As JSON");
  command->callback([options, &action] { action = [options] { return Run(*options); }; });
}

}  // namespace isthmus::cli
