#include "client/cli/offline_program.h"

#include <absl/strings/str_cat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

#include "client/console/exit_code.h"
#include "client/console/offline_commands.h"
#include "client/console/words.h"
#include "core/command_line/checks.h"

namespace isthmus::cli {
namespace {

namespace fs = std::filesystem;

// The folder of this program. Empty, so that nothing is found, where the system does not tell.
fs::path OwnFolder() {
  std::error_code unknown;
  return fs::read_symlink("/proc/self/exe", unknown).parent_path();
}

}  // namespace

std::string OfflineProgramFor(int argc, char** argv) {
  const std::vector<std::string> words = Words(argc, argv);
  const size_t command = CommandAt(words);
  if (command == words.size()) return {};
  const auto names = OfflineCommands();
  const auto found =
      std::ranges::find(names, std::string_view(words[command]), &OfflineCommand::name);
  return std::string(found == names.end() ? "" : found->program);
}

int BecomeOfflineProgram(const std::string& name, char** argv) {
  const fs::path here = OwnFolder();
  const fs::path libexec = (here / ISTHMUS_LIBEXEC_FROM_BIN).lexically_normal();
  for (const fs::path& folder : {here, libexec}) {
    std::string program = folder / name;
    std::error_code ignored;
    if (!fs::exists(program, ignored)) continue;
    argv[0] = program.data();
    execv(program.c_str(), argv);
    return Fail(kFailed, absl::FailedPreconditionError(
                             absl::StrCat("cannot run ", program, ": ", std::strerror(errno))));
  }
  return Fail(kFailed,
              absl::FailedPreconditionError(absl::StrCat(
                  "this command needs the program ", name, ", which is neither in ", here.string(),
                  " nor in ", libexec.string(), "; the Debian package of the same name has it")));
}

void ListOfflineCommands(CLI::App& app, Action&) {
  for (const OfflineCommand& command : OfflineCommands()) {
    AddOfflineCommand(app, command.name)->group("Subcommands that need no server");
  }
}

}  // namespace isthmus::cli
