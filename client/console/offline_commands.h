// The commands that need no server, by name: programs of their own have them, so that `isthmus`
// carries no server and starts at once on a robot, and a robot need not have what only experiments
// or fleets need.
#pragma once

#include <CLI/App.hpp>
#include <span>
#include <string_view>

namespace isthmus::cli {

struct OfflineCommand {
  std::string_view name, description;
  std::string_view program;  // And its Debian package.
};

// In the order in which the help lists them.
std::span<const OfflineCommand> OfflineCommands();

// Adds the command of that name, which must be one of them, with its description.
CLI::App* AddOfflineCommand(CLI::App& app, std::string_view name);

}  // namespace isthmus::cli
