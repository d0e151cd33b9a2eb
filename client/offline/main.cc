// isthmus-offline: commands that need no server. `isthmus` becomes this program when it is given
// one of them, so to a person there is one command line. See docs/cli.md.
#include "client/offline/commands.h"

int main(int argc, char** argv) {
  using namespace isthmus::cli;
  CLI::App app{"Commands of isthmus that need no server.", "isthmus"};
  constexpr AddCommand kCommands[] = {AddOdometry, AddMerge, AddRebuild, AddOptimize};
  return RunCommandLine(app, kCommands, argc, argv);
}
