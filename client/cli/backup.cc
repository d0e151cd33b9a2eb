// isthmus backup: a copy of the server's map folder.
#include <absl/strings/str_format.h>

#include <optional>

#include "api/convert/graph.h"
#include "client/console/command.h"
#include "client/console/console.h"
#include "client/console/exit_code.h"
#include "client/console/json.h"
#include "client/console/say.h"

namespace isthmus::cli {
namespace {

struct BackupOptions {
  ServerOptions server;
  std::string output;
  bool tokens = false, json = false;
};

// First the copy that the server makes, then the bytes that arrive.
class Bars {
 public:
  explicit Bars(const std::string& output) : output_(output) {
    bar_.emplace("copying at the server", 100);
  }
  void Update(const client::BackupState& state) {
    if (state.total_bytes > 0 && !is_sending_) {
      is_sending_ = true;
      bar_.emplace(output_, state.total_bytes);
    }
    bar_->Update(is_sending_ ? state.bytes : static_cast<uint64_t>(100 * state.copied));
  }

 private:
  const std::string output_;
  std::optional<Progress> bar_;
  bool is_sending_ = false;
};

int Run(const BackupOptions& options) {
  const auto client = Connect(options.server);
  if (!client.ok()) return FailServer(client.status());
  absl::StatusOr<client::Backup> backup;
  {
    Bars bars(options.output);
    backup = (*client)->BackUp(
        options.output, [&](const client::BackupState& state) { bars.Update(state); },
        options.tokens);
  }
  if (!backup.ok()) return FailServer(backup.status());
  if (options.json) {
    Json out = {{"folder", options.output},
                {"revision", backup->file.revision},
                {"size", backup->file.size},
                {"crc32c", absl::StrFormat("%08x", backup->file.crc32c)},
                {"tokens", backup->has_tokens}};
    out.update(ToJson(convert::ToMessage(backup->contents)));
    Print(out);
  } else {
    Say("%s: %s, revision %d, %d sessions, %d submaps, %d scans\n", options.output,
        HumanBytes(backup->file.size), backup->file.revision, backup->contents.sessions,
        backup->contents.submaps, backup->contents.scans);
    if (backup->contents.damaged > 0) SayLines(backup->contents.report);
  }
  if (options.tokens && !backup->has_tokens) {
    Warn(
        "isthmus: the server gave no tokens: it has none, or is older than this program. A server "
        "of this copy lets everybody do everything\n");
  }
  return kOk;
}

}  // namespace

void AddBackup(CLI::App& app, Action& action) {
  auto options = std::make_shared<BackupOptions>();
  CLI::App* command = app.add_subcommand(
      "backup",
      "A copy of the server's map while it is in use, as a folder that isthmus-server can serve");
  AddServerOptions(*command, options->server);
  command->add_option("output", options->output, "FOLDER, which must not exist yet")->required();
  command->add_flag("--tokens", options->tokens,
                    "Copy the server's tokens too, so that the copy is not open to everybody");
  command->add_flag("--json", options->json, "Summary as JSON");
  command->callback([options, &action] { action = [options] { return Run(*options); }; });
}

}  // namespace isthmus::cli
