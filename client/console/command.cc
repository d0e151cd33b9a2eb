#include "client/console/command.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "client/console/exit_code.h"
#include "client/console/words.h"

namespace isthmus::cli {

int RunCommandLine(CLI::App& app, std::span<const AddCommand> commands, int argc, char** argv) {
  app.require_subcommand(1);
  app.set_version_flag("--version", ISTHMUS_VERSION);
  Action action;
  for (const AddCommand add : commands) add(app, action);
  app.footer(
      "`isthmus help COMMAND` is `isthmus COMMAND --help`. --server and --attempts may stand "
      "before\n"
      "the command too.");
  std::vector<std::string> words = Words(argc, argv);
  if (absl::Status status = CheckCommand(words, app); !status.ok()) return Fail(kUsage, status);
  words = Arranged(words, app);
  std::ranges::reverse(words);  // As CLI11 takes them.
  try {
    app.parse(std::move(words));
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? kOk : kUsage;  // Prints help, version or what is wrong.
  }
  return action();
}

void AddServerOptions(CLI::App& command, ServerOptions& options) {
  command.add_option("--server", options.address, "Address of isthmus-server, HOST:PORT")
      ->envname("ISTHMUS_SERVER")
      ->capture_default_str();
  command
      .add_option("--attempts", options.attempts,
                  "How often to try to reach the server, waiting ever longer (up to 5 s)")
      ->check(CLI::Range(1, 1000000))
      ->capture_default_str();
}

absl::StatusOr<std::unique_ptr<client::Client>> Connect(const ServerOptions& options) {
  client::ClientOptions out;
  out.address = options.address;
  out.backoff.max_attempts = options.attempts;
  return client::Client::Connect(out);
}

absl::StatusOr<std::unique_ptr<client::Client>> ConnectPatiently(const ServerOptions& options,
                                                                 bool may_begin_alone) {
  ServerOptions once = options;
  once.attempts = 1;
  const absl::Status reached = Connect(once).status();
  if (absl::IsUnavailable(reached) && options.attempts > 1) {
    absl::FPrintF(stderr, "isthmus: no server at %s yet: %s\n", options.address,
                  may_begin_alone
                      ? "scans wait in the spool"
                      : absl::StrCat("trying ", options.attempts - 1, " times more (--attempts)"));
  } else if (!reached.ok()) {
    return reached;
  }
  client::ClientOptions out;
  out.address = options.address;
  out.backoff.max_attempts = options.attempts;
  out.require_server = !may_begin_alone;
  return client::Client::Connect(out);
}

}  // namespace isthmus::cli
