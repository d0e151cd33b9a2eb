// The command line of Isthmus. See docs/cli.md.
#include "client/cli/offline_program.h"
#include "client/console/command.h"

namespace isthmus::cli {

using Command = void(CLI::App& app, Action& action);

// The commands that ask a server, each in the file of its name.
Command AddInfo, AddPush, AddUpload, AddStatus, AddRobots, AddSession, AddGraph, AddMatch, AddLoops,
    AddRevisions, AddChanges, AddAnchor, AddDatum, AddCerts, AddToken, AddLog, AddTrajectory,
    AddTransform, AddQuery, AddExport, AddBackup, AddPicture, AddReport, AddTop, AddView, AddWatch;

}  // namespace isthmus::cli

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
