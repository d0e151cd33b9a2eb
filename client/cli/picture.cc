// isthmus picture: the merged map from above, each robot in its own colour.
#include "client/evaluation/picture.h"

#include <absl/strings/str_cat.h>
#include <absl/time/clock.h>
#include <absl/time/time.h>

#include "client/cli/region_options.h"
#include "client/console/command.h"
#include "client/console/exit_code.h"
#include "client/console/output_name.h"
#include "client/console/region_reader.h"
#include "client/console/say.h"
#include "client/exports/tracks.h"
#include "core/io/output_file.h"
#include "core/records/map_tracks.h"

namespace isthmus::cli {
namespace {

struct PictureOptions {
  ServerOptions server;
  RegionOptions region;
  evaluation::PictureOptions picture;
  std::string output;
};

int Run(const PictureOptions& options) {
  auto query = ParseRegion(options.region);
  if (!query.ok()) return Fail(kUsage, query.status());
  if (absl::Status status = io::CheckOutput(options.output); !status.ok()) return FailInput(status);
  const auto client = Connect(options.server);
  if (!client.ok()) return FailServer(client.status());
  auto info = (*client)->GetMapInfo();
  if (!info.ok()) return FailServer(info.status());
  // Points and ways are asked for one after the other: of one map, whatever its number becomes.
  const MapName& asked = options.region.query.component;
  const auto map = StableName(*info, asked);
  if (!map.ok()) return FailServer(map.status());
  query->component = *map;
  const auto region = ReadRegion(**client, *query);
  if (!region.ok()) return FailServer(region.status());
  SayWhichMap(**client, asked);
  if (region->points.empty()) {
    return Fail(kNoAnswer, absl::FailedPreconditionError(
                               query->box ? "the map has no points between --min-z and --max-z"
                                          : "the map has no points yet"));
  }
  auto tracks = ReadTracks(exports::TracksOf(**client), *std::move(info), *map);
  if (!tracks.ok()) return FailServer(tracks.status());
  std::vector<std::string> names;
  for (const RobotId& robot : region->robots) names.push_back(robot.value());
  evaluation::PictureOptions picture = options.picture;
  picture.caption = absl::StrCat(
      "revision ", region->revision, ", ",
      absl::FormatTime("%Y-%m-%d %H:%M UTC", absl::Now(), absl::UTCTimeZone()), ", x and y in m");
  const absl::Status written =
      evaluation::WritePicture(options.output, region->points,
                               NewestWays(*std::move(tracks), region->robots), names, picture,
                               /*world_file=*/!io::IsStandardOutput(options.output));
  if (!written.ok()) return Fail(kFailed, written);
  if (io::IsStandardOutput(options.output)) return kOk;
  Say("%s: %d points of %d sessions, revision %d\n", options.output, region->points.size(),
      region->robots.size(), region->revision);
  return kOk;
}

}  // namespace

void AddPicture(CLI::App& app, Action& action) {
  auto options = std::make_shared<PictureOptions>();
  evaluation::PictureOptions& picture = options->picture;
  CLI::App* command =
      app.add_subcommand("picture", "The merged map from above as PNG, coloured by robot");
  AddServerOptions(*command, options->server);
  AddMapOption(*command, options->region.query.component);
  command->add_option("--size", picture.max_side_px, "Length of the longer side, pixels")
      ->check(CLI::Range(200, 10000))
      ->capture_default_str();
  AddHeightOptions(*command, options->region);
  command->add_flag("!--no-grid", picture.grid, "Without grid and origin");
  command->add_flag("--dark", picture.dark, "Light on black");
  command->add_option("-o,--output", options->output, "FILE.png")
      ->check(OutputNamed({".png"}))
      ->required();
  command->callback([options, &action] { action = [options] { return Run(*options); }; });
}

}  // namespace isthmus::cli
