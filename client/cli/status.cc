// isthmus status: what the server has and whether it is still at work.
#include <absl/strings/str_format.h>
#include <absl/strings/str_join.h>

#include <algorithm>
#include <vector>

#include "client/cli/command.h"
#include "client/cli/exit_code.h"
#include "client/cli/json.h"
#include "client/cli/waiting.h"

namespace isthmus::cli {
namespace {

struct Options {
  ServerOptions server;
  std::string wait;
  double timeout_s = 300;
  bool json = false;
};

int64_t Rejected(const std::vector<client::Loop>& loops) {
  return std::count_if(loops.begin(), loops.end(),
                       [](const client::Loop& loop) { return loop.loop.rejected; });
}

void Report(const client::MapInfo& info, const std::vector<client::Loop>& loops,
            const std::string& address) {
  absl::PrintF("server       %s\nrevision     %d\nstate        %s\nrobots       %d\n", address,
               info.revision, info.settled ? "settled" : "at work", info.robots.size());
  for (const client::Component& component : info.components) {
    const std::string robots =
        absl::StrJoin(component.robots, ", ",
                      [](std::string* out, const RobotId& robot) { out->append(robot.value()); });
    absl::PrintF("component %-2d %s (%d points, frame of %s)\n", component.component, robots,
                 component.point_count, component.reference.value());
  }
  absl::PrintF("submaps      %d in the map, %d retired since the server started\n", info.submaps,
               info.retired);
  absl::PrintF("loops        %d closed, %d of them rejected by hand\n", loops.size(),
               Rejected(loops));
  absl::PrintF("composition  %.1f ms the last of %d, %.1f ms the longest\n", info.composition_ms,
               info.compositions, info.composition_max_ms);
  absl::PrintF("placement    %.1f ms the last of %d\n", info.placement_ms, info.placements);
  absl::PrintF("estimation   %.0f ms the last of %d\n", info.estimation_ms, info.estimations);
}

int Run(const Options& options) {
  const auto client = Connect(options.server);
  if (!client.ok()) return FailServer(client.status());
  const auto info =
      options.wait.empty()
          ? (*client)->GetMapInfo()
          : Wait(**client, options.wait == "merged" ? WaitFor::kMerged : WaitFor::kSettled,
                 options.timeout_s);
  if (absl::IsDeadlineExceeded(info.status())) return Fail(kNoAnswer, info.status());
  if (!info.ok()) return FailServer(info.status());
  const auto loops = (*client)->ListLoops();
  if (!loops.ok()) return FailServer(loops.status());
  if (options.json) {
    Json out = ToJson(*info);
    out["loops"] = loops->size();
    out["loops_rejected"] = Rejected(*loops);
    Print(out);
  } else {
    Report(*info, *loops, options.server.address);
  }
  return kOk;
}

}  // namespace

void AddStatus(CLI::App& app, Action& action) {
  auto options = std::make_shared<Options>();
  CLI::App* command =
      app.add_subcommand("status", "What the server has, and whether it is at work");
  AddServerOptions(*command, options->server);
  command
      ->add_option("--wait", options->wait,
                   "Wait until the server has nothing left to do (settled), or has in addition put "
                   "all robots into one map (merged)")
      ->check(CLI::IsMember({"settled", "merged"}));
  command->add_option("--timeout", options->timeout_s, "Seconds to wait at most")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  command->add_flag("--json", options->json, "As JSON");
  command->callback([options, &action] { action = [options] { return Run(*options); }; });
}

}  // namespace isthmus::cli
