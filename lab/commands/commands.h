// The commands of isthmus-lab, one file each.
#pragma once

#include "client/console/command.h"

namespace isthmus::cli {

void AddSimulate(CLI::App& app, Action& action);
void AddEval(CLI::App& app, Action& action);
void AddBench(CLI::App& app, Action& action);

}  // namespace isthmus::cli
