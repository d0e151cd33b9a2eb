// The command line of Isthmus. See docs/cli.md.
#include "client/cli/command.h"
#include "client/cli/exit_code.h"

int main(int argc, char** argv) {
  using namespace isthmus::cli;
  CLI::App app{"Isthmus joins the maps of many robots into one.", "isthmus"};
  app.require_subcommand(1);
  app.set_version_flag("--version", ISTHMUS_VERSION);
  Action action;
  for (const auto add :
       {AddSimulate, AddPush,   AddStatus,    AddRobots,  AddGraph,    AddTrajectory, AddTransform,
        AddQuery,    AddExport, AddBackup,    AddPicture, AddOdometry, AddMerge,      AddRebuild,
        AddMatch,    AddLoops,  AddRevisions, AddAnchor,  AddOptimize, AddEval,       AddBench}) {
    add(app, action);
  }
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? kOk : kUsage;  // Prints help, version or what is wrong.
  }
  return action();
}
