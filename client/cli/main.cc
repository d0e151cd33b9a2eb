// The command line of Isthmus. See docs/cli.md.
#include "client/cli/commands.h"
#include "client/cli/offline_program.h"

int main(int argc, char** argv) {
  using namespace isthmus::cli;
  if (const std::string program = OfflineProgramFor(argc, argv); !program.empty()) {
    return BecomeOfflineProgram(program, argv);
  }
  CLI::App app{"Isthmus joins the maps of many robots into one.", "isthmus"};
  constexpr AddCommand kCommands[] = {
      AddInfo,    AddPush,   AddUpload,     AddStatus,    AddRobots, AddSession,         AddGraph,
      AddMatch,   AddLoops,  AddRevisions,  AddChanges,   AddAnchor, AddDatum,           AddCerts,
      AddToken,   AddLog,    AddTrajectory, AddTransform, AddQuery,  AddExport,          AddBackup,
      AddPicture, AddReport, AddTop,        AddView,      AddWatch,  ListOfflineCommands};
  return RunCommandLine(app, kCommands, argc, argv);
}
