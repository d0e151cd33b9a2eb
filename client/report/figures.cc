#include "client/report/figures.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/str_replace.h>
#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <filesystem>
#include <system_error>

#include "client/report/figures_script.h"
#include "core/io/file_io.h"

namespace isthmus::report {
namespace {

namespace fs = std::filesystem;

constexpr int kNoMatplotlib = 3;  // Format: how figures.py ends without it.
constexpr int kNoProgram = 127;   // Format: how a child ends that could not be started.

std::string Python() {
  if (const char* chosen = std::getenv("ISTHMUS_PYTHON")) return chosen;
  std::error_code ignored;
  return fs::exists("/usr/bin/python3", ignored) ? "/usr/bin/python3" : "python3";
}

// Its exit code; what it says goes to the file `log`.
int RunScript(const std::string& python, const std::string& script, const std::string& log) {
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, log.c_str(),
                                   O_WRONLY | O_CREAT | O_TRUNC, 0644);
  posix_spawn_file_actions_adddup2(&actions, STDOUT_FILENO, STDERR_FILENO);
  const char* const arguments[] = {python.c_str(), script.c_str(), nullptr};
  pid_t child = 0;
  const int failed = posix_spawnp(&child, python.c_str(), &actions, nullptr,
                                  const_cast<char* const*>(arguments), environ);
  posix_spawn_file_actions_destroy(&actions);
  if (failed != 0) return kNoProgram;
  int status = 0;
  while (waitpid(child, &status, 0) < 0) {
    if (errno != EINTR) return kNoProgram;
  }
  return WIFEXITED(status) ? WEXITSTATUS(status) : 1;
}

absl::Status WriteInput(const std::string& folder, const std::vector<Figure>& figures) {
  std::error_code failed;
  fs::create_directories(folder, failed);
  if (failed) return io::FileError("create folder", folder, failed.value());
  cli::Json document = {{"figures", figures}};
  // Names come from robots: what is not UTF-8 is replaced rather than refused.
  const std::string text = document.dump(1, ' ', false, cli::Json::error_handler_t::replace);
  absl::Status written = io::WriteFile(folder + "/figures.json", text + "\n");
  if (written.ok()) written = io::WriteFile(folder + "/figures.py", kFiguresScript);
  return written;
}

}  // namespace

absl::Status DrawFigures(const std::string& folder, const std::vector<Figure>& figures) {
  if (absl::Status written = WriteInput(folder, figures); !written.ok()) return written;
  const std::string python = Python(), log = folder + "/figures.log";
  const int code = RunScript(python, folder + "/figures.py", log);
  if (code == kNoMatplotlib || code == kNoProgram) {
    fs::remove(log);
    return absl::FailedPreconditionError(absl::StrCat(
        "figures are drawn by Matplotlib, which ", python,
        code == kNoProgram ? " (not there) is to run" : " does not have",
        "; install it: sudo apt-get install python3-matplotlib (or name another Python in the "
        "environment's ISTHMUS_PYTHON)"));
  }
  if (code != 0) {
    const auto said = io::ReadFile(log);
    return absl::InternalError(absl::StrCat(
        python, " ", folder,
        "/figures.py failed: ", said.ok() ? *said : std::string(said.status().message())));
  }
  fs::remove(log);
  return absl::OkStatus();
}

absl::StatusOr<std::string> InlineSvg(const std::string& folder, const std::string& file) {
  auto svg = io::ReadFile(absl::StrCat(folder, "/", file, ".svg"));
  if (!svg.ok()) return svg.status();
  const size_t head = svg->find("<svg");
  if (head == std::string::npos) {
    return absl::InternalError(absl::StrCat(folder, "/", file, ".svg is no SVG file"));
  }
  svg->erase(0, head);
  const size_t metadata = svg->find("<metadata>"), end = svg->find("</metadata>");
  if (metadata != std::string::npos && end != std::string::npos) {
    svg->erase(metadata, end + sizeof("</metadata>") - 1 - metadata);
  }
  return absl::StrReplaceAll(*svg, {{"id=\"", absl::StrCat("id=\"", file, "-")},
                                    {"url(#", absl::StrCat("url(#", file, "-")},
                                    {"href=\"#", absl::StrCat("href=\"#", file, "-")},
                                    {"#202428", "currentColor"},
                                    {"#ffffff", "none"},
                                    {"#fefefe", "var(--ground)"}});
}

}  // namespace isthmus::report
