#include "core/command_line/checks.h"

#include <absl/strings/str_cat.h>

#include <algorithm>
#include <filesystem>
#include <system_error>

#include "core/plain_text.h"

namespace isthmus {
namespace {

absl::Status CheckValues(const CLI::App& app) {
  for (const CLI::Option* option : app.get_options()) {
    if (!option->nonpositional() || !std::ranges::count(option->results(), "")) continue;
    return absl::InvalidArgumentError(
        absl::StrCat(option->get_name(), " has no value: is a variable of the shell not set?"));
  }
  for (const CLI::App* command : app.get_subcommands()) {
    if (absl::Status status = CheckValues(*command); !status.ok()) return status;
  }
  return absl::OkStatus();
}

}  // namespace

std::vector<std::string> Words(int argc, const char* const* argv) {
  return {argv + std::min(argc, 1), argv + argc};
}

absl::Status CheckText(const std::vector<std::string>& words) {
  std::error_code error;
  for (const std::string& word : words) {
    if (IsUtf8(word) || std::filesystem::exists(word, error)) continue;
    return absl::InvalidArgumentError(
        absl::StrCat("\"", ValidUtf8(word), "\" is not text in UTF-8, nor a file that is there"));
  }
  return absl::OkStatus();
}

absl::Status CheckValues(const std::vector<std::string>& words, const CLI::App& app) {
  // CLI11 gives an empty value to an option that may go without one, too.
  const bool has_empty = std::ranges::any_of(words, [](const std::string& word) {
    return word.empty() || (word.starts_with('-') && word.ends_with('='));
  });
  return has_empty ? CheckValues(app) : absl::OkStatus();
}

}  // namespace isthmus
