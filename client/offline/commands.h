// The commands that need no server, one file each; client/console/offline_commands.h names them.
#pragma once

#include "client/console/command.h"

namespace isthmus::cli {

void AddSimulate(CLI::App& app, Action& action);
void AddOdometry(CLI::App& app, Action& action);
void AddMerge(CLI::App& app, Action& action);
void AddRebuild(CLI::App& app, Action& action);
void AddCopy(CLI::App& app, Action& action);
void AddOptimize(CLI::App& app, Action& action);
void AddEval(CLI::App& app, Action& action);
void AddBench(CLI::App& app, Action& action);

}  // namespace isthmus::cli
