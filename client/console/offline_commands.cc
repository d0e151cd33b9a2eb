#include "client/console/offline_commands.h"

#include <algorithm>
#include <string>

namespace isthmus::cli {
namespace {

constexpr OfflineCommand kCommands[] = {
    {"simulate", "Simulated robots with ground truth", "isthmus-lab"},
    {"odometry", "Trajectory of a recorded drive; needs no server", "isthmus-offline"},
    {"merge", "Merge files: finished maps and recorded drives; needs no server", "isthmus-offline"},
    {"rebuild",
     "Compute a map again from its archived scans, with other parameters; needs no server",
     "isthmus-offline"},
    {"copy", "Copy a map between folders and PostgreSQL databases; needs no server",
     "isthmus-fleet"},
    {"optimize", "Optimise the poses of a g2o file by its edges", "isthmus-offline"},
    {"eval", "Errors of trajectories against the truth", "isthmus-lab"},
    {"bench", "Reproducible comparisons", "isthmus-lab"},
};

}  // namespace

std::span<const OfflineCommand> OfflineCommands() { return kCommands; }

CLI::App* AddOfflineCommand(CLI::App& app, std::string_view name) {
  const auto* command = std::ranges::find(kCommands, name, &OfflineCommand::name);
  return app.add_subcommand(std::string(command->name), std::string(command->description));
}

}  // namespace isthmus::cli
