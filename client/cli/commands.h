// The commands that ask a server, one file each.
#pragma once

#include "client/console/command.h"

namespace isthmus::cli {

void AddInfo(CLI::App& app, Action& action);
void AddPush(CLI::App& app, Action& action);
void AddUpload(CLI::App& app, Action& action);
void AddStatus(CLI::App& app, Action& action);
void AddRobots(CLI::App& app, Action& action);
void AddSession(CLI::App& app, Action& action);
void AddGraph(CLI::App& app, Action& action);
void AddMatch(CLI::App& app, Action& action);
void AddLog(CLI::App& app, Action& action);
void AddLoops(CLI::App& app, Action& action);
void AddRevisions(CLI::App& app, Action& action);
void AddChanges(CLI::App& app, Action& action);
void AddAnchor(CLI::App& app, Action& action);
void AddDatum(CLI::App& app, Action& action);
void AddCerts(CLI::App& app, Action& action);
void AddTrajectory(CLI::App& app, Action& action);
void AddTransform(CLI::App& app, Action& action);
void AddQuery(CLI::App& app, Action& action);
void AddExport(CLI::App& app, Action& action);
void AddBackup(CLI::App& app, Action& action);
void AddPicture(CLI::App& app, Action& action);
void AddToken(CLI::App& app, Action& action);
void AddTop(CLI::App& app, Action& action);
void AddView(CLI::App& app, Action& action);
void AddWatch(CLI::App& app, Action& action);
void AddReport(CLI::App& app, Action& action);

}  // namespace isthmus::cli
