// The hand-over from `isthmus` to isthmus-offline, whose commands it offers by becoming that
// program.
#pragma once

#include "client/console/command.h"

namespace isthmus::cli {

// True if the command line names one of them, or asks for its help.
bool NamesOfflineCommand(int argc, char** argv);

// Runs isthmus-offline in place of this program with the same arguments, so that exit code, signals
// and streams are its own. It is looked for beside this program, then in libexec. Returns an
// ExitCode, having said why, only if it cannot be run.
int BecomeOfflineProgram(char** argv);

// For the help: adds their names and descriptions, which are never parsed here.
void ListOfflineCommands(CLI::App& app, Action& action);

}  // namespace isthmus::cli
