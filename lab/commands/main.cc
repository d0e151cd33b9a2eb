// isthmus-lab: simulated robots, their errors, and comparisons. `isthmus` becomes this program when
// it is given one of its commands. See docs/cli.md.
#include "lab/commands/commands.h"

int main(int argc, char** argv) {
  using namespace isthmus::cli;
  CLI::App app{"Commands of isthmus for experiments.", "isthmus"};
  constexpr AddCommand kCommands[] = {AddSimulate, AddEval, AddBench};
  return RunCommandLine(app, kCommands, argc, argv);
}
