// isthmus rebuild: a map made anew, with other parameters, from the scans that were archived.

#include <cstdio>
#include <optional>

#include "client/console/console.h"
#include "client/console/exit_code.h"
#include "client/console/json.h"
#include "client/console/offline_commands.h"
#include "client/console/say.h"
#include "client/offline/commands.h"
#include "client/offline/config_option.h"
#include "client/offline/rebuild_map.h"

namespace isthmus::cli {
namespace {

struct RebuildArguments {
  RebuildOptions rebuild;
  std::string config;
  std::vector<std::string> sessions;
  bool json = false;
};

Json ToJson(const RebuildSummary& summary, const std::string& folder) {
  Json sessions = Json::array();
  for (const RebuiltSession& session : summary.sessions) {
    sessions.push_back({{"session", session.id.value()},
                        {"copied", session.is_copied},
                        {"scans", session.scans},
                        {"processed", session.processed},
                        {"missing", session.missing},
                        {"submaps", session.submaps},
                        {"segments", session.segments},
                        {"compared", session.compared},
                        {"rmse_m", session.rmse_m},
                        {"max_m", session.max_m}});
  }
  return {{"folder", folder},
          {"sessions", std::move(sessions)},
          {"manual_decisions", summary.manual_decisions},
          {"anchors", summary.anchors},
          {"notes", summary.notes}};
}

void PrintText(const RebuildSummary& summary, const std::string& folder) {
  for (const RebuiltSession& session : summary.sessions) {
    if (session.is_copied) {
      Say("%s: no archived scans; %d submaps were copied unchanged\n", session.id.value(),
          session.submaps);
      continue;
    }
    Say("%s: %d of %d scans, %d missing, %d submaps in %d segments; old and new poses %.4f m "
        "apart (RMS of %d, at most %.4f m)\n",
        session.id.value(), session.processed, session.scans, session.missing, session.submaps,
        session.segments, session.rmse_m, session.compared, session.max_m);
  }
  for (const std::string& note : summary.notes) Say("%s\n", note);
  Say("%s: %d sessions, %d manual decisions and %d anchors carried over\n", folder,
      summary.sessions.size(), summary.manual_decisions, summary.anchors);
}

int Run(RebuildArguments options) {
  const auto config = LoadConfig(options.config);
  if (!config.ok()) return FailInput(config.status());
  options.rebuild.pipeline = config->pipeline;
  options.rebuild.storage = config->storage;
  for (const std::string& session : options.sessions) {
    options.rebuild.sessions.emplace_back(session);
  }
  std::optional<Progress> bar;
  const auto summary = RebuildMap(options.rebuild, [&](uint64_t done, uint64_t total) {
    if (!bar) bar.emplace("scans", total);
    bar->Update(done);
  });
  bar.reset();
  if (absl::IsNotFound(summary.status()) && !options.sessions.empty()) {
    return Fail(kUnknown, summary.status());
  }
  const bool is_input = absl::IsNotFound(summary.status()) ||
                        absl::IsAlreadyExists(summary.status()) ||
                        absl::IsFailedPrecondition(summary.status());
  if (is_input) return FailInput(summary.status());
  if (!summary.ok()) return Fail(kFailed, summary.status());
  if (options.json) {
    Print(ToJson(*summary, options.rebuild.to));
  } else {
    PrintText(*summary, options.rebuild.to);
  }
  return kOk;
}

}  // namespace

void AddRebuild(CLI::App& app, Action& action) {
  auto options = std::make_shared<RebuildArguments>();
  CLI::App* command = AddOfflineCommand(app, "rebuild");
  command->add_option("DIR", options->rebuild.from, "Map folder with an archive of scans")
      ->required();
  command->add_option("--to", options->rebuild.to, "New map folder")->required();
  AddConfigOption(*command, options->config);
  command->add_option("--sessions", options->sessions, "Only these sessions; without it all")
      ->delimiter(',');
  command->add_flag("--with-scans", options->rebuild.with_scans,
                    "Copy the archive to the new folder too (hard links where possible)");
  command->add_flag("--json", options->json, "Summary as JSON");
  command->callback([options, &action] { action = [options] { return Run(*options); }; });
}

}  // namespace isthmus::cli
