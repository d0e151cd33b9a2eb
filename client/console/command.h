// A command of the command line: added to its program by one function, run after parsing.
#pragma once

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <functional>
#include <memory>
#include <span>
#include <string>

#include "client/library/client.h"

namespace isthmus::cli {

// Set by the command that was named; returns an ExitCode.
using Action = std::function<int()>;

// Adds one command; `action` outlives the parsing.
using AddCommand = void (*)(CLI::App& app, Action& action);

// Parses the command line and runs what it names. Prints help, version and usage errors itself.
int RunCommandLine(CLI::App& app, std::span<const AddCommand> commands, int argc, char** argv);

// Options of every command that speaks to a server.
struct ServerOptions {
  std::string address = "localhost:50051";
  int attempts = 5;
  client::TlsOptions tls = {};
  std::string token_file = {}, site = {};
};
void AddServerOptions(CLI::App& command, ServerOptions& options);
// Without --site, for what is about the server itself.
void AddSitelessOptions(CLI::App& command, ServerOptions& options);
// With what the files that they name hold. The file's error; InvalidArgument where one of
// certificate and key is missing.
absl::StatusOr<client::ClientOptions> ClientOptionsOf(const ServerOptions& options);
absl::StatusOr<std::unique_ptr<client::Client>> Connect(const ServerOptions& options);

// About a minute, for commands that send what took long to record.
inline constexpr int kPatientAttempts = 16;
// As Connect, but says at once, on stderr, that the server is out of reach, and for how long it
// will be tried. Where `may_begin_alone`, returns at once all the same: for spools.
absl::StatusOr<std::unique_ptr<client::Client>> ConnectPatiently(const ServerOptions& options,
                                                                 bool may_begin_alone = false);

}  // namespace isthmus::cli
