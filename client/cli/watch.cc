// isthmus watch: the merged map as it changes.
#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>

#include <cstdio>
#include <string>
#include <vector>

#include "client/cli/commands.h"
#include "client/console/exit_code.h"
#include "client/console/json.h"
#include "client/console/localising_text.h"
#include "client/console/numbers.h"
#include "client/console/say.h"
#include "core/plain_text.h"

namespace isthmus::cli {
namespace {

struct WatchOptions {
  ServerOptions server;
  uint32_t level = 0;
  uint64_t steps = 0;  // 0: without end.
  bool robots = false, json = false;
};

Json ToJson(const TileId& id) {
  return {{"component", id.component}, {"level", id.level}, {"x", id.x}, {"y", id.y}};
}

Json ToJson(const SubmapPlace& place) {
  Json json{{"session", place.submap.session.value()},
            {"index", place.submap.index},
            {"robot", place.robot.value()},
            {"component", nullptr},
            {"T_map_submap", nullptr}};
  if (!place.component) return json;
  json["component"] = *place.component;
  json["T_map_submap"] = cli::ToJson(place.T_map_submap);
  return json;
}

Json ToJson(const MapStep& step) {
  Json json{{"revision", step.mark.revision}, {"restart", step.restart}};
  json["tiles"] = json["removed_tiles"] = json["submaps"] = json["matches"] =
      json["removed_matches"] = Json::array();
  for (const TileInfo& tile : step.tiles) {
    Json added = ToJson(tile.id);
    added["version"] = absl::StrFormat("%016x", tile.version);
    added["points"] = tile.points;
    json["tiles"].push_back(std::move(added));
  }
  for (const TileId& tile : step.removed_tiles) json["removed_tiles"].push_back(ToJson(tile));
  for (const SubmapPlace& place : step.submaps) json["submaps"].push_back(ToJson(place));
  for (const MatchEdge& edge : step.matches) json["matches"].push_back(cli::ToJson(edge));
  for (const auto& [a, b] : step.removed_matches) {
    json["removed_matches"].push_back({{"session_a", a.value()}, {"session_b", b.value()}});
  }
  json["robots"] = nullptr;
  if (!step.robots) return json;
  json["robots"] = Json::array();
  for (const RobotPlace& place : *step.robots) json["robots"].push_back(cli::ToJson(place));
  return json;
}

bool HasMapNews(const MapStep& step) {
  return step.restart || !step.tiles.empty() || !step.removed_tiles.empty() ||
         !step.submaps.empty() || !step.matches.empty() || !step.removed_matches.empty();
}

void PrintText(const MapStep& step, bool robots) {
  if (HasMapNews(step)) {
    Say("revision %d: %d tiles %s, %d removed; %d submaps, %d matches\n", step.mark.revision,
        step.tiles.size(), step.restart ? "in all" : "changed", step.removed_tiles.size(),
        step.submaps.size(), step.matches.size() + step.removed_matches.size());
  }
  if (!robots || !step.robots) return;
  for (const RobotPlace& place : *step.robots) {
    const std::string at = PlaceText(place);
    const char* state = place.localising ? ToString(place.localising->state) : "";
    Say("  %s %s, %.0f ms behind%s%s\n", NameOf(place), at.empty() ? "not placed yet" : at,
        place.lag_ms, place.localising ? ", is localised: " : "", state);
  }
}

int RunWatch(const WatchOptions& options) {
  const auto client = Connect(options.server);
  if (!client.ok()) return FailServer(client.status());
  MapMark known;
  uint64_t shown = 0;
  const auto take = [&](const MapStep& step) {
    known = step.mark;
    if (!HasMapNews(step) && !options.robots) return true;
    if (!options.json) {
      PrintText(step, options.robots);
    } else {
      PrintLine(ToJson(step));
    }
    std::fflush(stdout);
    return ++shown != options.steps;
  };
  constexpr size_t kMaxLine = 400;
  while (true) {
    const absl::Status status = (*client)->WatchMap(known, options.level, take);
    if (status.ok()) return kOk;
    if (!absl::IsUnavailable(status)) return FailServer(status);
    Warn("isthmus: %s; trying again\n", isthmus::LineOf(status.message(), kMaxLine));
  }
}

}  // namespace

void AddWatch(CLI::App& app, Action& action) {
  auto options = std::make_shared<WatchOptions>();
  CLI::App* command = app.add_subcommand("watch", "The map as it changes, until Ctrl-C");
  AddServerOptions(*command, options->server);
  command->add_option("--level", options->level, "Level of detail of the tiles; 0: the map's own")
      ->check(NotNegative())
      ->check(CLI::Range(0, 30))
      ->capture_default_str();
  command->add_option("--steps", options->steps, "End after this many steps; 0: never")
      ->check(NotNegative())
      ->capture_default_str();
  command->add_flag("--robots", options->robots,
                    "Also show the robots' places, at most twice a second");
  command->add_flag("--json", options->json, "One JSON object per line");
  command->callback([options, &action] { action = [options] { return RunWatch(*options); }; });
}

}  // namespace isthmus::cli
