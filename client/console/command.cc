#include "client/console/command.h"

#include <absl/strings/ascii.h>
#include <absl/strings/str_cat.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "client/console/exit_code.h"
#include "client/console/say.h"
#include "client/console/words.h"
#include "client/library/spool/spool_options.h"
#include "client/library/tls_files.h"
#include "core/command_line/checks.h"
#include "core/io/file_io.h"
#include "core/io/of_file.h"

namespace isthmus::cli {
namespace {

// Prints help, version or what is wrong, which repeats what was given: a token, perhaps.
int Exit(const CLI::App& app, const CLI::ParseError& error) {
  std::ostringstream out, wrong;
  const bool is_asked = app.exit(error, out, wrong) == 0;
  const std::string help = out.str();  // Holds a NUL for each enumerator that is 0.
  std::fwrite(help.data(), 1, help.size(), stdout);
  if (is_asked) return kOk;
  std::fprintf(stderr, "isthmus: %s", Lines(wrong.str()).c_str());
  return kUsage;
}

}  // namespace

int RunCommandLine(CLI::App& app, std::span<const AddCommand> commands, int argc, char** argv) {
  setenv("GRPC_VERBOSITY", "NONE", 0);  // Errors come back as statuses.
  app.require_subcommand(1);
  app.set_version_flag("--version", ISTHMUS_VERSION);
  Action action;
  for (const AddCommand add : commands) add(app, action);
  app.footer(
      "`isthmus help COMMAND` is `isthmus COMMAND --help`. --server and --attempts may stand "
      "before\n"
      "the command too.");
  std::vector<std::string> words = Words(argc, argv);
  absl::Status status = CheckText(words);
  if (status.ok()) status = CheckCommand(words, app);
  if (!status.ok()) return Fail(kUsage, status);
  words = Arranged(words, app);
  std::ranges::reverse(words);  // As CLI11 takes them.
  try {
    app.parse(std::move(words));
  } catch (const CLI::ParseError& error) {
    return Exit(app, error);
  }
  if (status = CheckValues(Words(argc, argv), app); !status.ok()) return Fail(kUsage, status);
  const int code = action();
  if (std::fflush(stdout) == 0 && std::ferror(stdout) == 0) return code;
  const absl::Status lost =
      absl::UnavailableError("the output could not be written: is its disk full?");
  return code == kOk ? Fail(kFailed, lost) : code;
}

void AddServerOptions(CLI::App& command, ServerOptions& options) {
  AddSitelessOptions(command, options);
  command.add_option("--site", options.site, "Site of the server")->envname("ISTHMUS_SITE");
}

void AddSitelessOptions(CLI::App& command, ServerOptions& options) {
  command
      .add_option("--server", options.address,
                  "Address of isthmus-server, HOST:PORT; several servers of one map are separated "
                  "by commas")
      ->envname("ISTHMUS_SERVER")
      ->capture_default_str();
  command
      .add_option("--attempts", options.attempts,
                  "Connection attempts before giving up; waits between them grow up to 5 s")
      ->check(CLI::Range(1, 1000000))
      ->capture_default_str();
  command
      .add_option("--tls-ca", options.tls.ca,
                  "Use TLS with a server whose certificate this PEM file signed; \"system\": any "
                  "authority that this machine trusts")
      ->envname("ISTHMUS_TLS_CA");
  command.add_option("--tls-cert", options.tls.certificate, "PEM file of the client's certificate")
      ->envname("ISTHMUS_TLS_CERT");
  command.add_option("--tls-key", options.tls.key, "PEM file of the client's key")
      ->envname("ISTHMUS_TLS_KEY");
  command
      .add_option("--token-file", options.token_file,
                  "File with the token; without it ISTHMUS_TOKEN")
      ->envname("ISTHMUS_TOKEN_FILE");
}

absl::StatusOr<client::ClientOptions> ClientOptionsOf(const ServerOptions& options) {
  client::ClientOptions out;
  out.address = options.address;
  out.backoff.max_attempts = options.attempts;
  out.tls = options.tls;
  out.site = options.site;
  if (absl::Status status = client::CheckTlsFiles(options.tls); !status.ok()) {
    return absl::IsInvalidArgument(status) ? status : io::OfFile(status);
  }
  const char* const token = std::getenv("ISTHMUS_TOKEN");
  if (!options.token_file.empty()) {
    const auto text = io::ReadFile(options.token_file);
    if (!text.ok()) return io::OfFile(text.status());
    if (absl::StripAsciiWhitespace(*text).empty()) {
      return io::OfFile(absl::FailedPreconditionError(
          absl::StrCat("the token file ", options.token_file,
                       " is empty: `isthmus token create` prints its content")));
    }
    out.token = *text;
  } else if (token != nullptr) {
    out.token = token;
  }
  return out;
}

absl::StatusOr<std::unique_ptr<client::Client>> Connect(const ServerOptions& options) {
  const auto out = ClientOptionsOf(options);
  return out.ok() ? client::Client::Connect(*out) : out.status();
}

absl::StatusOr<std::unique_ptr<client::Client>> ConnectPatiently(const ServerOptions& options,
                                                                 bool may_begin_alone) {
  auto out = ClientOptionsOf(options);
  if (!out.ok()) return out.status();
  client::ClientOptions once = *out;
  once.backoff.max_attempts = 1;
  if (may_begin_alone) once.call_timeout_s = client::SpoolOptions().attempt_timeout_s;
  const absl::Status reached = client::Client::Connect(once).status();
  // One that takes connections and hangs is out of reach, too: a live sensor must not wait for it.
  const bool is_away =
      absl::IsUnavailable(reached) || (may_begin_alone && absl::IsDeadlineExceeded(reached));
  if (is_away && options.attempts > 1) {
    Warn("isthmus: no server at %s yet: %s\n", options.address,
         may_begin_alone
             ? "scans wait in the spool"
             : absl::StrCat("trying ", options.attempts - 1, " times more (--attempts)"));
  } else if (!reached.ok()) {
    return reached;
  }
  out->require_server = !may_begin_alone;
  return client::Client::Connect(*out);
}

}  // namespace isthmus::cli
