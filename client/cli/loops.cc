// isthmus loops: places that robots came back to, and a person's decision on them.
#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>

#include <vector>

#include "client/console/command.h"
#include "client/console/exit_code.h"
#include "client/console/json.h"
#include "client/console/numbers.h"
#include "client/console/say.h"

namespace isthmus::cli {
namespace {

struct LoopsOptions {
  ServerOptions server;
  std::string robot;
  LoopDecision decision;
  bool edges = false, json = false;
};

std::string StateOf(const Loop& loop) {
  if (loop.loop.rejected) return "REJECTED";
  return loop.edges_used > 0 ? "USED" : "SET ASIDE";
}

std::string Percent(double share) {
  return share < 0 ? std::string("-") : absl::StrFormat("%.0f %%", 100 * share);
}

void Report(const std::vector<Loop>& loops) {
  if (loops.empty()) {
    Warn("isthmus: no robot was found to have come back to a place yet\n");
    return;
  }
  Say("%6s  %-16s %-11s  %-9s  %10s %7s %8s  %7s  %s\n", "id", "session", "submaps", "state",
      "confidence", "overlap", "residual", "edges", "detail");
  for (const Loop& record : loops) {
    const LoopClosure& loop = record.loop;
    const std::string residual =
        loop.residual_m < 0 ? std::string("-") : absl::StrFormat("%.3f m", loop.residual_m);
    Say("%6d  %-16s %-11s  %-9s  %10.2f %7s %8s  %7s  %s\n", loop.id, loop.session.value(),
        absl::StrCat(loop.submap_a, " ~ ", loop.submap_b), StateOf(record), loop.confidence,
        Percent(loop.overlap), residual, absl::StrCat(record.edges_used, "/", record.edge_count),
        loop.note.empty() ? loop.detail : absl::StrCat("\"", loop.note, "\" ", loop.detail));
  }
}

int RunList(const LoopsOptions& options) {
  const auto client = Connect(options.server);
  if (!client.ok()) return FailServer(client.status());
  const auto loops = (*client)->ListLoops(RobotId(options.robot), options.edges);
  if (!loops.ok()) return FailServer(loops.status());
  if (!options.json) {
    Report(*loops);
    return kOk;
  }
  Json out = Json::array();
  for (const Loop& loop : *loops) out.push_back(ToJson(loop));
  Print({{"loops", std::move(out)}});
  return kOk;
}

int RunDecide(const LoopsOptions& options, bool rejected) {
  const auto client = Connect(options.server);
  if (!client.ok()) return FailServer(client.status());
  LoopDecision decision = options.decision;
  decision.rejected = rejected;
  const auto decided = (*client)->DecideLoop(decision);
  if (!decided.ok()) return FailServer(decided.status());
  if (options.json) {
    Print(ToJson(decided->loop));
  } else {
    Report({decided->loop});
  }
  return kOk;
}

void AddDecision(CLI::App& loops, Action& action, const std::shared_ptr<LoopsOptions>& options,
                 const std::string& name, const std::string& what, bool rejected) {
  CLI::App* command = loops.add_subcommand(name, what);
  command->fallthrough();
  command->add_option("ID", options->decision.id, "Number of the loop, from `isthmus loops`")
      ->check(Positive())
      ->required();
  command->add_option("--note", options->decision.note, "Reason; stored with the decision");
  command->footer("--server, --attempts and --json as for `isthmus loops`.");
  command->callback([options, rejected, &action] {
    action = [options, rejected] { return RunDecide(*options, rejected); };
  });
}

}  // namespace

void AddLoops(CLI::App& app, Action& action) {
  auto options = std::make_shared<LoopsOptions>();
  CLI::App* command = app.add_subcommand(
      "loops", "List the loops: places to which robots came back; reject one by hand");
  AddServerOptions(*command, options->server);
  command->add_option("ROBOT", options->robot, "Only loops of this robot");
  command->add_flag("--edges", options->edges, "With --json: also the submap pairs of each loop");
  command->add_flag("--json", options->json, "As JSON");
  AddDecision(*command, action, options, "reject",
              "Reject a loop closure: it has no effect on the map", true);
  AddDecision(*command, action, options, "restore", "Use a rejected loop closure again", false);
  command->callback([options, command, &action] {  // Also after a subcommand's.
    if (command->get_subcommands().empty()) {
      action = [options] { return RunList(*options); };
    } else if (!options->robot.empty()) {
      throw CLI::ExtrasError(command->get_name(), {options->robot});
    }
  });
}

}  // namespace isthmus::cli
