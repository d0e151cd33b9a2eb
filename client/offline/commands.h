// The commands of isthmus-offline, one file each.
#pragma once

#include "client/console/command.h"

namespace isthmus::cli {

void AddOdometry(CLI::App& app, Action& action);
void AddMerge(CLI::App& app, Action& action);
void AddRebuild(CLI::App& app, Action& action);
void AddOptimize(CLI::App& app, Action& action);

}  // namespace isthmus::cli
