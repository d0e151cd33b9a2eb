// isthmus robots: every session of every robot, and those that are localised.

#include <optional>

#include "client/cli/session_list.h"
#include "client/console/command.h"
#include "client/console/exit_code.h"

namespace isthmus::cli {
namespace {

struct RobotsOptions {
  ServerOptions server;
  bool json = false;
};

int Run(const RobotsOptions& options) {
  const auto client = Connect(options.server);
  if (!client.ok()) return FailServer(client.status());
  const auto sessions = (*client)->ListSessions();
  if (!sessions.ok()) return FailServer(sessions.status());
  // A robot learns of its own sessions alone; older servers have no status.
  const auto status = (*client)->GetStatus();
  const bool is_silent =
      absl::IsPermissionDenied(status.status()) || absl::IsUnimplemented(status.status());
  if (!status.ok() && !is_silent) return FailServer(status.status());
  PrintSessions(*sessions, options.json, status.ok() ? std::optional(status->load) : std::nullopt);
  return kOk;
}

}  // namespace

void AddRobots(CLI::App& app, Action& action) {
  auto options = std::make_shared<RobotsOptions>();
  CLI::App* command = app.add_subcommand(
      "robots", "All robots with their sessions, and the robots that are localised");
  AddServerOptions(*command, options->server);
  command->add_flag("--json", options->json, "As JSON");
  command->callback([options, &action] { action = [options] { return Run(*options); }; });
}

}  // namespace isthmus::cli
