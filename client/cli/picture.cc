// isthmus picture: the merged map from above, each robot in its own colour.
#include "client/evaluation/picture.h"

#include <absl/strings/str_cat.h>
#include <absl/time/clock.h>
#include <absl/time/time.h>

#include "client/cli/commands.h"
#include "client/cli/region_options.h"
#include "client/console/exit_code.h"
#include "client/console/output_name.h"
#include "client/console/region_reader.h"
#include "client/console/say.h"
#include "core/io/output_file.h"

namespace isthmus::cli {
namespace {

struct PictureOptions {
  ServerOptions server;
  RegionQuery query;
  evaluation::PictureOptions picture;
  std::string output;
};

// The ways of the robots in that map, in the order of `robots`; empty for the others.
absl::StatusOr<std::vector<Trajectory>> Ways(client::Client& client, const MapName& map,
                                             const std::vector<RobotId>& robots) {
  const auto info = client.GetMapInfo();
  if (!info.ok()) return info.status();
  const auto number = NumberIn(*info, map);
  if (!number.ok()) return number.status();
  std::vector<Trajectory> trajectories(robots.size());
  for (size_t i = 0; i < robots.size(); ++i) {
    auto trajectory = client.GetTrajectory(robots[i], TrajectoryFrame::kMap);
    if (absl::IsFailedPrecondition(trajectory.status()))
      continue;  // Not placed: not in the picture.
    if (!trajectory.ok()) return trajectory.status();
    if (trajectory->component == *number) trajectories[i] = std::move(trajectory->poses);
  }
  return trajectories;
}

int Run(const PictureOptions& options) {
  if (absl::Status status = io::CheckOutput(options.output); !status.ok()) return FailInput(status);
  const auto client = Connect(options.server);
  if (!client.ok()) return FailServer(client.status());
  const auto region = ReadRegion(**client, options.query);
  if (!region.ok()) return FailServer(region.status());
  if (region->points.empty()) {
    return Fail(kNoAnswer, absl::FailedPreconditionError("the map has no points yet"));
  }
  const auto trajectories = Ways(**client, options.query.component, region->robots);
  if (!trajectories.ok()) return FailServer(trajectories.status());
  std::vector<std::string> names;
  for (const RobotId& robot : region->robots) names.push_back(robot.value());
  evaluation::PictureOptions picture = options.picture;
  picture.caption = absl::StrCat(
      "revision ", region->revision, ", ",
      absl::FormatTime("%Y-%m-%d %H:%M UTC", absl::Now(), absl::UTCTimeZone()), ", x and y in m");
  const absl::Status written =
      evaluation::WritePicture(options.output, region->points, *trajectories, names, picture,
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
  AddMapOption(*command, options->query.component);
  command->add_option("--size", picture.max_side_px, "Pixels of the longer side")
      ->check(CLI::Range(200, 10000))
      ->capture_default_str();
  command->add_option("--min-z", picture.min_z_m, "Leave out points below, metres in the map");
  command->add_option("--max-z", picture.max_z_m, "Leave out points above");
  command->add_flag("!--no-grid", picture.grid, "Without grid and origin");
  command->add_flag("--dark", picture.dark, "Light on black");
  command->add_option("-o,--output", options->output, "FILE.png")
      ->check(OutputNamed({".png"}))
      ->required();
  command->callback([options, &action] { action = [options] { return Run(*options); }; });
}

}  // namespace isthmus::cli
