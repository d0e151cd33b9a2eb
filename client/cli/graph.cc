// isthmus graph: the matches between robots, and which of them carry the map; the pose graph.
#include <absl/strings/str_format.h>
#include <absl/strings/str_replace.h>

#include <algorithm>
#include <map>
#include <utility>
#include <vector>

#include "client/cli/region_options.h"
#include "client/console/command.h"
#include "client/console/console.h"
#include "client/console/drive_orders.h"
#include "client/console/exit_code.h"
#include "client/console/json.h"
#include "client/console/match_text.h"
#include "client/console/output_name.h"
#include "client/console/pose_text.h"
#include "client/console/region_reader.h"
#include "client/console/say.h"
#include "core/io/output_file.h"

namespace isthmus::cli {
namespace {

struct GraphOptions {
  ServerOptions server;
  std::string format = "text";
  bool edges = false;
  std::string g2o;
  MapName map;
};

// Loops that closed move the reference's newest poses too.
std::string PlaceText(const Pose& T_map_odom, bool reference) {
  if (!reference) return PoseText(T_map_odom);
  const bool moved = T_map_odom.translation().norm() > 1e-3 || RotationAngle(T_map_odom) > 1e-4;
  return moved ? "the reference, now " + PoseText(T_map_odom) : std::string("the reference");
}

// Map by map, who lies where.
void PrintPlacements(const MatchGraph& graph) {
  std::map<uint32_t, std::vector<const PlacedSession*>> components;
  for (const PlacedSession& placed : graph.placements) {
    components[placed.placement.component].push_back(&placed);
  }
  Say("revision %d, sessions: %d, maps: %d\n", graph.revision, graph.placements.size(),
      components.size());
  for (const auto& [number, sessions] : components) {
    const std::string& reference = sessions.front()->placement.reference.value();
    Say("map %d, in the frame of %s\n", number, reference);
    for (const PlacedSession* placed : sessions) {
      const std::string& session = placed->placement.session.value();
      Say("  %-16s %s\n", session, PlaceText(placed->placement.T_map_odom, session == reference));
    }
  }
}

// Matches that carry the map come first, then other accepted ones, then the rest.
void PrintText(const MatchGraph& graph) {
  PrintPlacements(graph);
  std::vector<const MatchEdge*> edges;
  for (const MatchEdge& edge : graph.matches) edges.push_back(&edge);
  const auto accepted = [](const MatchEdge* edge) {
    return edge->match.state == MatchState::kAccepted;
  };
  std::stable_sort(edges.begin(), edges.end(), [&](const MatchEdge* l, const MatchEdge* r) {
    return std::make_pair(l->in_tree, accepted(l)) > std::make_pair(r->in_tree, accepted(r));
  });
  const auto count = std::count_if(edges.begin(), edges.end(), accepted);
  Say("matches: %d, accepted: %d\n", edges.size(), count);
  for (const MatchEdge* edge : edges) SayLines("\n" + MatchText(*edge));
  if (count < static_cast<int64_t>(edges.size())) {
    Say("\ndocs/concepts.md, \"Reasons\", explains the reasons and their remedies.\n");
  }
}

std::string Quote(const std::string& text) {
  return "\"" + absl::StrReplaceAll(text, {{"\\", "\\\\"}, {"\"", "\\\""}}) + "\"";
}

// For Graphviz: solid where a match carries the map, dashed where it was accepted, dotted
// otherwise.
void PrintDot(const MatchGraph& graph) {
  Say("graph matches {\n  node [shape=box];\n");
  for (const PlacedSession& placed : graph.placements) {
    Say("  %s [group=\"map %d\"];\n", Quote(placed.placement.session.value()),
        placed.placement.component);
  }
  for (const MatchEdge& edge : graph.matches) {
    const char* style = edge.in_tree                                ? "solid"
                        : edge.match.state == MatchState::kAccepted ? "dashed"
                                                                    : "dotted";
    Say("  %s -- %s [style=%s, label=%s];\n", Quote(edge.match.a.value()),
        Quote(edge.match.b.value()), style,
        Quote(absl::StrFormat("%s %.2f", ToString(edge.match.reason), edge.match.confidence)));
  }
  Say("}\n");
}

int SaveG2o(client::Client& client, const GraphOptions& options) {
  const auto summary = client.ExportPoseGraphToFile(options.map, options.g2o);
  if (!summary.ok()) return FailServer(summary.status());
  SayWhichMap(client, options.map);
  if (io::IsStandardOutput(options.g2o)) return kOk;
  if (options.format == "json") {
    Print({{"file", options.g2o},
           {"component", options.map.session().empty() ? Json(options.map.number())
                                                       : Json(options.map.ToText())},
           {"revision", summary->revision},
           {"size", summary->size}});
  } else {
    Say("%s: pose graph of map %s, %s, revision %d\n", options.g2o, options.map.ToText(),
        HumanBytes(summary->size), summary->revision);
  }
  return kOk;
}

int Run(const GraphOptions& options) {
  if (!options.g2o.empty()) {
    const absl::Status usable = io::CheckOutput(options.g2o);
    if (!usable.ok()) return FailInput(usable);
  }
  const auto client = Connect(options.server);
  if (!client.ok()) return FailServer(client.status());
  if (!options.g2o.empty()) return SaveG2o(**client, options);
  const auto graph = (*client)->GetMatchGraph(options.edges);
  if (!graph.ok()) return FailServer(graph.status());
  if (options.format == "json") {
    Print(ToJson(*graph));
  } else if (options.format == "dot") {
    PrintDot(*graph);
  } else if (options.format == "nav2") {
    Print(NavigationGoals(*graph));
  } else if (options.format == "vda5050") {
    Print(VehicleOrders(*graph));
  } else {
    PrintText(*graph);
  }
  return kOk;
}

}  // namespace

void AddGraph(CLI::App& app, Action& action) {
  auto options = std::make_shared<GraphOptions>();
  CLI::App* command = app.add_subcommand("graph", "Matches between robots, with their reasons");
  AddServerOptions(*command, options->server);
  command
      ->add_option("--format", options->format,
                   "dot is for Graphviz; nav2 and vda5050 are the drives that are asked for")
      ->check(CLI::IsMember({"text", "json", "dot", "nav2", "vda5050"}))
      ->capture_default_str();
  command->add_flag_callback(
      "--json", [format = &options->format] { *format = "json"; }, "As --format json");
  command->add_flag("--edges", options->edges, "With --json: also the submap pairs of each match");
  CLI::Option* g2o = command
                         ->add_option("--g2o", options->g2o,
                                      "FILE for the pose graph of a map: submaps and their edges")
                         ->check(OutputNamed({".g2o"}));
  AddMapOption(*command, options->map, "With --g2o. ")->needs(g2o);
  command->callback([options, &action] { action = [options] { return Run(*options); }; });
}

}  // namespace isthmus::cli
