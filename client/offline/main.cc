// isthmus-offline: the commands that need no server. `isthmus` becomes this program when it is
// given one of them, so to a person there is one command line. See docs/cli.md.
#include "client/offline/commands.h"

int main(int argc, char** argv) {
  using namespace isthmus::cli;
  CLI::App app{"The commands of isthmus that need no server.", "isthmus"};
  constexpr AddCommand kCommands[] = {AddSimulate, AddOdometry, AddMerge, AddRebuild,
                                      AddCopy,     AddOptimize, AddEval,  AddBench};
  return RunCommandLine(app, kCommands, argc, argv);
}
