// isthmus graph: the matches between robots, and which of them carry the map.
#include <absl/strings/str_format.h>
#include <absl/strings/str_replace.h>

#include "client/cli/command.h"
#include "client/cli/exit_code.h"
#include "client/cli/json.h"
#include "client/cli/match_text.h"
#include "client/cli/pose_text.h"

namespace isthmus::cli {
namespace {

struct Options {
  ServerOptions server;
  std::string format = "text";
  bool edges = false;
};

void PrintText(const client::MatchGraph& graph) {
  absl::PrintF("revision %d\n", graph.revision);
  for (const client::PlacedSession& placed : graph.placements) {
    absl::PrintF("%-16s component %d, %s in the frame of %s\n", placed.placement.session.value(),
                 placed.placement.component, PoseText(placed.placement.T_map_odom),
                 placed.placement.reference.value());
  }
  for (const client::MatchEdge& edge : graph.matches) {
    absl::PrintF("%s", MatchText(edge));
  }
}

std::string Quote(const std::string& text) {
  return "\"" + absl::StrReplaceAll(text, {{"\\", "\\\\"}, {"\"", "\\\""}}) + "\"";
}

// For Graphviz: solid where a match carries the map, dashed where it was accepted, dotted
// otherwise.
void PrintDot(const client::MatchGraph& graph) {
  absl::PrintF("graph matches {\n  node [shape=box];\n");
  for (const client::PlacedSession& placed : graph.placements) {
    absl::PrintF("  %s [group=\"component %d\"];\n", Quote(placed.placement.session.value()),
                 placed.placement.component);
  }
  for (const client::MatchEdge& edge : graph.matches) {
    const char* style = edge.in_tree                                ? "solid"
                        : edge.match.state == MatchState::kAccepted ? "dashed"
                                                                    : "dotted";
    absl::PrintF("  %s -- %s [style=%s, label=%s];\n", Quote(edge.match.a.value()),
                 Quote(edge.match.b.value()), style,
                 Quote(absl::StrFormat("%s %.2f", edge.match.reason, edge.match.confidence)));
  }
  absl::PrintF("}\n");
}

int Run(const Options& options) {
  const auto client = Connect(options.server);
  if (!client.ok()) return FailServer(client.status());
  const auto graph = (*client)->GetMatchGraph(options.edges);
  if (!graph.ok()) return FailServer(graph.status());
  if (options.format == "json") {
    Print(ToJson(*graph, options.edges));
  } else if (options.format == "dot") {
    PrintDot(*graph);
  } else {
    PrintText(*graph);
  }
  return kOk;
}

}  // namespace

void AddGraph(CLI::App& app, Action& action) {
  auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand("graph", "Matches between robots, with their reasons");
  AddServerOptions(*command, options->server);
  command->add_option("--format", options->format)
      ->check(CLI::IsMember({"text", "json", "dot"}))
      ->capture_default_str();
  command->add_flag("--edges", options->edges,
                    "With --format json: the submaps that carry each match, too");
  command->callback([options, &action] { action = [options] { return Run(*options); }; });
}

}  // namespace isthmus::cli
