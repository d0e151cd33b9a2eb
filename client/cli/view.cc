// isthmus view: the address of the server's pages, and a browser at it.
#include <absl/strings/match.h>
#include <absl/strings/str_cat.h>
#include <absl/strings/str_replace.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <string>

#include "client/console/command.h"
#include "client/console/exit_code.h"
#include "client/console/say.h"

namespace isthmus::cli {
namespace {

struct ViewOptions {
  ServerOptions server;
  bool print = false;
};

// "[::1]" of "[::1]:50051", "box" of "box:50051".
std::string HostOf(const std::string& address) { return address.substr(0, address.rfind(':')); }

// As this machine reaches it: a server that listens at all its addresses does so at that one, too.
std::string Reachable(const std::string& web, const std::string& server) {
  const std::string host = HostOf(server);
  if (absl::StartsWith(server, "unix")) return web;
  return absl::StrReplaceAll(web, {{"//0.0.0.0:", absl::StrCat("//", host, ":")},
                                   {"//[::]:", absl::StrCat("//", host, ":")}});
}

// Opens the browser if there is a screen, and a program that knows the browser.
void OpenBrowser(const std::string& address) {
  if (getenv("DISPLAY") == nullptr && getenv("WAYLAND_DISPLAY") == nullptr) return;
  std::string name = "xdg-open", argument = address;
  char* const arguments[] = {name.data(), argument.data(), nullptr};
  pid_t process = 0;
  if (posix_spawnp(&process, name.c_str(), nullptr, nullptr, arguments, environ) != 0) return;
  int status = 0;
  waitpid(process, &status, 0);
}

int Run(const ViewOptions& options) {
  const auto client = Connect(options.server);
  if (!client.ok()) return FailServer(client.status());
  const auto status = (*client)->GetStatus();
  if (!status.ok()) return FailServer(status.status());
  if (status->web_address.empty()) {
    return Fail(kFailed, absl::FailedPreconditionError(
                             "this server serves no pages: set web.listen in its settings, for "
                             "example to 127.0.0.1:8080, and restart it"));
  }
  const std::string address = Reachable(status->web_address, options.server.address);
  Say("%s\n", address);
  std::fflush(stdout);
  if (!options.print) OpenBrowser(address);
  return kOk;
}

}  // namespace

void AddView(CLI::App& app, Action& action) {
  auto options = std::make_shared<ViewOptions>();
  CLI::App* command = app.add_subcommand("view", "Open the server's map in the browser");
  AddServerOptions(*command, options->server);
  command->add_flag("--print", options->print, "Only print the address");
  command->callback([options, &action] { action = [options] { return Run(*options); }; });
}

}  // namespace isthmus::cli
