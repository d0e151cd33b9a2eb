// isthmus watch: the merged map as it changes.
#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>

#include <cstdio>
#include <string>
#include <vector>

#include "api/convert/graph.h"
#include "api/convert/map_changes.h"
#include "client/console/command.h"
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

v1::WatchMapResponse ToMessage(const MapStep& step) {
  v1::WatchMapResponse message;
  message.set_revision(step.mark.revision);
  message.set_run(step.mark.run);
  message.set_restart(step.restart);
  message.set_tile_m(step.tile_m);
  for (const TileInfo& tile : step.tiles) *message.add_tiles() = convert::ToMessage(tile);
  for (const TileId& tile : step.removed_tiles) {
    *message.add_removed_tiles() = convert::ToMessage(tile);
  }
  for (const SubmapPlace& place : step.submaps) *message.add_submaps() = convert::ToMessage(place);
  for (const MatchEdge& edge : step.matches) *message.add_matches() = convert::ToMessage(edge);
  for (const auto& [a, b] : step.removed_matches) {
    v1::SessionPair& pair = *message.add_removed_matches();
    pair.set_session_a(a.value());
    pair.set_session_b(b.value());
  }
  message.set_has_robots(step.robots.has_value());
  if (!step.robots) return message;
  for (const RobotPlace& place : *step.robots) *message.add_robots() = convert::ToMessage(place);
  return message;
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
      PrintLine(ToJson(ToMessage(step)));
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
