// How commands are added to the program: one file each, one function each.
#pragma once

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <functional>
#include <memory>
#include <string>

#include "client/library/client.h"

namespace isthmus::cli {

// Set by the command that was named; returns an ExitCode.
using Action = std::function<int()>;

// Options of every command that speaks to a server.
struct ServerOptions {
  std::string address = "localhost:50051";
  int attempts = 5;
};
void AddServerOptions(CLI::App& command, ServerOptions& options);
absl::StatusOr<std::unique_ptr<client::Client>> Connect(const ServerOptions& options);

void AddSimulate(CLI::App& app, Action& action);
void AddPush(CLI::App& app, Action& action);
void AddStatus(CLI::App& app, Action& action);
void AddRobots(CLI::App& app, Action& action);
void AddGraph(CLI::App& app, Action& action);
void AddTrajectory(CLI::App& app, Action& action);
void AddTransform(CLI::App& app, Action& action);
void AddQuery(CLI::App& app, Action& action);
void AddExport(CLI::App& app, Action& action);
void AddBackup(CLI::App& app, Action& action);
void AddPicture(CLI::App& app, Action& action);
void AddOdometry(CLI::App& app, Action& action);
void AddMatch(CLI::App& app, Action& action);
void AddRevisions(CLI::App& app, Action& action);
void AddLoops(CLI::App& app, Action& action);
void AddAnchor(CLI::App& app, Action& action);
void AddOptimize(CLI::App& app, Action& action);
void AddMerge(CLI::App& app, Action& action);
void AddRebuild(CLI::App& app, Action& action);
void AddEval(CLI::App& app, Action& action);
void AddBench(CLI::App& app, Action& action);

}  // namespace isthmus::cli
