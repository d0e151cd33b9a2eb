// isthmus match: a person's decision on how two robots' maps lie to each other.
#include <absl/strings/str_cat.h>
#include <absl/strings/str_join.h>

#include <vector>

#include "client/cli/joined.h"
#include "client/console/command.h"
#include "client/console/exit_code.h"
#include "client/console/json.h"
#include "client/console/match_text.h"
#include "client/console/say.h"
#include "core/geometry/angles.h"

namespace isthmus::cli {
namespace {

struct MatchOptions {
  ServerOptions server;
  std::string a, b;
  bool sessions = false;
  std::vector<double> pose;  // x y z roll pitch yaw, metres and degrees.
  std::string note;
  bool json = false;
};

Pose PoseOf(const std::vector<double>& numbers) {
  return Pose::FromXyzRpy(numbers[0], numbers[1], numbers[2], numbers[3] * kRadPerDeg,
                          numbers[4] * kRadPerDeg, numbers[5] * kRadPerDeg);
}

using Sessions = std::vector<SessionId>;

std::string JoinedText(const Match& match, const std::optional<Sessions>& way) {
  const std::string both = absl::StrCat(match.a.value(), " and ", match.b.value());
  if (!way) return both + " are now in different maps\n";
  const std::string names = absl::StrJoin(
      *way, ", ",
      [](std::string* out, const SessionId& session) { absl::StrAppend(out, session.value()); });
  return absl::StrCat(both, " stay joined, through ", names.empty() ? "other segments" : names,
                      ": to separate them, reject a match of that chain too\n");
}

int Run(const MatchOptions& options, std::optional<ManualDecisionKind> kind) {
  const auto client = Connect(options.server);
  if (!client.ok()) return FailServer(client.status());
  MatchDecision decision;
  if (options.sessions) {
    decision.session_a = SessionId(options.a);
    decision.session_b = SessionId(options.b);
  } else {
    decision.robot_a = RobotId(options.a);
    decision.robot_b = RobotId(options.b);
  }
  decision.kind = kind;
  decision.note = options.note;
  if (!options.pose.empty()) decision.T_a_b = PoseOf(options.pose);
  const auto decided = (*client)->DecideMatch(decision);
  if (!decided.ok()) return FailServer(decided.status());
  const auto graph = (*client)->GetMatchGraph();
  if (!graph.ok()) return FailServer(graph.status());
  const Match& match = decided->edge.match;
  const auto way = WayBetween(*graph, match.a, match.b);
  if (options.json) {
    Json out = ToJson(decided->edge);
    out["joined"] = way.has_value();
    out["joined_through"] = Json::array();
    for (const SessionId& session : way.value_or(Sessions())) {
      out["joined_through"].push_back(session.value());
    }
    Print(out);
    return kOk;
  }
  SayLines(MatchText(decided->edge));
  // The user who parts two maps wants to know if they are apart now.
  if (kind == ManualDecisionKind::kReject) SayLines(JoinedText(match, way));
  return kOk;
}

void AddDecision(CLI::App& match, Action& action, const std::string& name, const std::string& what,
                 std::optional<ManualDecisionKind> kind) {
  auto options = std::make_shared<MatchOptions>();
  CLI::App* command = match.add_subcommand(name, what);
  AddServerOptions(*command, options->server);
  command->add_option("A", options->a, "Robot: stands for its newest session")->required();
  command->add_option("B", options->b, "The other robot, likewise")->required();
  command->add_flag("--sessions", options->sessions, "A and B are sessions");
  if (kind == ManualDecisionKind::kSet) {
    command
        ->add_option("--pose", options->pose,
                     "X Y Z ROLL PITCH YAW of B's odom frame in A's: metres and degrees")
        ->expected(6)
        ->required();
  }
  if (kind) command->add_option("--note", options->note, "Reason; stored with the decision");
  command->add_flag("--json", options->json, "Print the match that is in effect now, as JSON");
  command->callback(
      [options, kind, &action] { action = [options, kind] { return Run(*options, kind); }; });
}

}  // namespace

void AddMatch(CLI::App& app, Action& action) {
  CLI::App* match =
      app.add_subcommand("match", "Accept, reject or set the match of two robots by hand");
  match->require_subcommand(1);
  AddDecision(*match, action, "accept", "Use the transform that was computed last",
              ManualDecisionKind::kAccept);
  AddDecision(*match, action, "reject", "Keep the two apart, also if a later match is accepted",
              ManualDecisionKind::kReject);
  AddDecision(*match, action, "set", "Use the given pose", ManualDecisionKind::kSet);
  AddDecision(*match, action, "withdraw", "Withdraw the decision; the computed match counts again",
              std::nullopt);
}

}  // namespace isthmus::cli
