// The commands that need no server, by name: a program of their own has them, isthmus-offline, so
// that `isthmus` carries no server and starts at once on a robot.
#pragma once

#include <CLI/App.hpp>
#include <span>
#include <string_view>

namespace isthmus::cli {

inline constexpr char kOfflineProgram[] = "isthmus-offline";  // And its Debian package.

struct OfflineCommand {
  std::string_view name, description;
};

// In the order in which the help lists them.
std::span<const OfflineCommand> OfflineCommands();

// Adds the command of that name, which must be one of them, with its description.
CLI::App* AddOfflineCommand(CLI::App& app, std::string_view name);

}  // namespace isthmus::cli
