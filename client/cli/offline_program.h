// The hand-over from `isthmus` to the programs whose commands it offers by becoming them:
// isthmus-offline, isthmus-lab and isthmus-fleet.
#pragma once

#include <string>

#include "client/console/command.h"

namespace isthmus::cli {

// The program that has the command which the command line names, or asks for the help of; empty if
// this one has it.
std::string OfflineProgramFor(int argc, char** argv);

// Runs that program in place of this one with the same arguments, so that exit code, signals and
// streams are its own. It is looked for beside this program, then in libexec. Returns an ExitCode,
// having said why, only if it cannot be run.
int BecomeOfflineProgram(const std::string& name, char** argv);

// For the help: adds their names and descriptions, which are never parsed here.
void ListOfflineCommands(CLI::App& app, Action& action);

}  // namespace isthmus::cli
