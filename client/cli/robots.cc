// isthmus robots: every session of every robot.

#include "client/cli/commands.h"
#include "client/cli/session_list.h"
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
  PrintSessions(*sessions, options.json);
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
