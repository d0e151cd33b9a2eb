#include "client/console/offline_commands.h"

#include <algorithm>
#include <string>

namespace isthmus::cli {
namespace {

constexpr OfflineCommand kCommands[] = {
    {"simulate", "Simulated robots with ground truth"},
    {"odometry", "Trajectory of a recorded drive; needs no server"},
    {"merge", "Merge files: finished maps and recorded drives; needs no server"},
    {"rebuild", "Make a map anew from its archived scans, with other parameters; needs no server"},
    {"copy", "Copy a map between folders and PostgreSQL databases; needs no server"},
    {"optimize", "Poses of a g2o file that agree best with its edges"},
    {"eval", "Errors of trajectories against the truth"},
    {"bench", "Comparisons that anyone can repeat"},
};

}  // namespace

std::span<const OfflineCommand> OfflineCommands() { return kCommands; }

CLI::App* AddOfflineCommand(CLI::App& app, std::string_view name) {
  const auto* command = std::ranges::find(kCommands, name, &OfflineCommand::name);
  return app.add_subcommand(std::string(command->name), std::string(command->description));
}

}  // namespace isthmus::cli
