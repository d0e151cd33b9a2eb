// isthmus anchor: places of submaps that are known from outside.
#include <absl/strings/match.h>
#include <absl/strings/str_format.h>

#include <optional>
#include <vector>

#include "api/convert/graph.h"
#include "client/cli/anchor_import.h"
#include "client/cli/site_reader.h"
#include "client/console/command.h"
#include "client/console/exit_code.h"
#include "client/console/json.h"
#include "client/console/numbers.h"
#include "client/console/pose_graph_file.h"
#include "client/console/pose_text.h"
#include "client/console/say.h"
#include "core/geometry/angles.h"

namespace isthmus::cli {
namespace {

struct AnchorOptions {
  ServerOptions server;
  std::string target, file;
  std::vector<double> position, rpy_deg;
  std::optional<double> latitude_deg, longitude_deg, altitude_m;
  Anchor anchor;  // Sigmas and note.
  bool json = false;
};

// As given, or by the datum.
absl::StatusOr<Eigen::Vector3d> PositionOf(client::Client& client, const AnchorOptions& options) {
  if (!options.position.empty()) return Eigen::Vector3d(options.position.data());
  const auto site = ReadAnchorsSite(client);
  if (!site.ok()) return site.status();
  return site->ToMap({*options.latitude_deg, *options.longitude_deg, *options.altitude_m});
}

Pose PoseAt(const Eigen::Vector3d& t, const AnchorOptions& options) {
  std::vector<double> rpy = options.rpy_deg;
  rpy.resize(3, 0.0);
  return Pose::FromXyzRpy(t.x(), t.y(), t.z(), rpy[0] * kRadPerDeg, rpy[1] * kRadPerDeg,
                          rpy[2] * kRadPerDeg);
}

bool SaysNothing(const Anchor& anchor) {
  return anchor.sigma_xy_m == 0 && anchor.sigma_z_m == 0 && anchor.sigma_deg == 0;
}

absl::Status SayHowWell() {
  return absl::InvalidArgumentError(
      "give the accuracy of the position: --sigma-xy, --sigma-z or --sigma-deg");
}

int RunSet(const AnchorOptions& options) {
  if (options.position.empty() && !options.latitude_deg) {
    return Fail(kUsage, absl::InvalidArgumentError(
                            "give the position: --position X Y Z, or --lat, --lon and --alt"));
  }
  if (SaysNothing(options.anchor)) return Fail(kUsage, SayHowWell());
  Anchor anchor = options.anchor;
  RobotId robot;
  if (absl::StrContains(options.target, '/')) {
    const auto submap = ParseSubmapId(options.target);
    if (!submap.ok()) return Fail(kUsage, submap.status());
    anchor.submap = *submap;
  } else {
    robot = RobotId(options.target);
  }
  const auto client = Connect(options.server);
  if (!client.ok()) return FailServer(client.status());
  const auto position = PositionOf(**client, options);
  if (!position.ok()) return FailServer(position.status());
  anchor.T_map_submap = PoseAt(*position, options);
  const auto anchored = (*client)->PutAnchor(anchor, robot);
  if (!anchored.ok()) return FailServer(anchored.status());
  if (options.json) {
    Print({{"session", anchored->submap.session.value()},
           {"index", anchored->submap.index},
           {"revision", anchored->revision}});
  } else {
    Say("%s is anchored: the map is at revision %d\n", ToString(anchored->submap),
        anchored->revision);
  }
  return kOk;
}

int RunRemove(const AnchorOptions& options) {
  const auto submap = ParseSubmapId(options.target);
  if (!submap.ok()) return Fail(kUsage, submap.status());
  const auto client = Connect(options.server);
  if (!client.ok()) return FailServer(client.status());
  const auto revision = (*client)->RemoveAnchor(*submap);
  if (!revision.ok()) return FailServer(revision.status());
  if (options.json) {
    Print(
        {{"session", submap->session.value()}, {"index", submap->index}, {"revision", *revision}});
  } else {
    Say("%s is no longer anchored: the map is at revision %d\n", options.target, *revision);
  }
  return kOk;
}

std::string SigmaText(double sigma, const char* unit) {
  return sigma > 0 ? absl::StrFormat("%.3g %s", sigma, unit) : std::string("free");
}

void Report(const std::vector<RobotAnchor>& anchors) {
  Say("%-20s %9s %9s %9s  %s\n", "submap", "sigma xy", "z", "turn", "place");
  for (const RobotAnchor& record : anchors) {
    const Anchor& anchor = record.anchor;
    Say("%-20s %9s %9s %9s  %s%s\n", ToString(anchor.submap), SigmaText(anchor.sigma_xy_m, "m"),
        SigmaText(anchor.sigma_z_m, "m"), SigmaText(anchor.sigma_deg, "deg"),
        PoseText(anchor.T_map_submap),
        anchor.note.empty() ? std::string() : "  \"" + anchor.note + "\"");
  }
}

int RunList(const AnchorOptions& options) {
  const auto client = Connect(options.server);
  if (!client.ok()) return FailServer(client.status());
  const auto anchors = (*client)->ListAnchors();
  if (!anchors.ok()) return FailServer(anchors.status());
  if (!options.json) {
    Report(*anchors);
    return kOk;
  }
  v1::ListAnchorsResponse response;
  response.set_revision(anchors->revision);
  for (const RobotAnchor& anchor : *anchors) *response.add_anchors() = convert::ToMessage(anchor);
  Print(ToJson(response));
  return kOk;
}

int RunImport(const AnchorOptions& options) {
  if (SaysNothing(options.anchor)) return Fail(kUsage, SayHowWell());
  const auto file = ReadPoseGraph(options.file);
  if (!file.ok()) return FailInput(file.status());
  if (file->graph.placed_by_edges > 0) {
    return FailInput(absl::InvalidArgumentError(
        absl::StrFormat("%s has no pose for %d vertices: optimise it first (isthmus optimize)",
                        options.file, file->graph.placed_by_edges)));
  }
  SayWhatIsMissing(options.file, file->graph);
  const std::vector<Anchor> anchors = AnchorsOf(*file, options.anchor);
  if (anchors.empty()) {
    return FailInput(absl::InvalidArgumentError(
        options.file +
        " names no submaps (\"# VERTEX 12 alice-1/7\"): begin with `isthmus graph --g2o`"));
  }
  const auto client = Connect(options.server);
  if (!client.ok()) return FailServer(client.status());
  const auto summary = PutAnchors(**client, anchors);
  if (!summary.ok()) return FailServer(summary.status());
  if (options.json) {
    Json unknown = Json::array();
    for (const SubmapId& submap : summary->unknown) unknown.push_back(ToString(submap));
    Print({{"anchored", summary->anchored},
           {"unknown", std::move(unknown)},
           {"revision", summary->revision}});
  } else {
    Say("%d submaps are anchored, %d are not in the map: it is at revision %d\n", summary->anchored,
        summary->unknown.size(), summary->revision);
  }
  return summary->anchored > 0 ? kOk : kUnknown;
}

// One subcommand with what all of them have.
CLI::App* Add(CLI::App& anchor, const std::string& name, const std::string& what, Action& action,
              const std::shared_ptr<AnchorOptions>& options, int (*run)(const AnchorOptions&)) {
  CLI::App* command = anchor.add_subcommand(name, what);
  AddServerOptions(*command, options->server);
  command->add_flag("--json", options->json, "Summary as JSON");
  command->callback([options, run, &action] { action = [options, run] { return run(*options); }; });
  return command;
}

// Returns --sigma-deg.
CLI::Option* AddSigmas(CLI::App& command, const std::shared_ptr<AnchorOptions>& options) {
  command
      .add_option("--sigma-xy", options->anchor.sigma_xy_m,
                  "Standard deviation of X and Y, m; without it X and Y are unknown")
      ->check(Positive());
  command
      .add_option("--sigma-z", options->anchor.sigma_z_m,
                  "Standard deviation of Z, m; without it the height is unknown")
      ->check(Positive());
  command.add_option("--note", options->anchor.note,
                     "Source of the position; stored with the anchor");
  return command
      .add_option("--sigma-deg", options->anchor.sigma_deg,
                  "Standard deviation of the rotation, degrees; without it the rotation is unknown")
      ->check(Positive());
}

// In place of a position.
void AddPlace(CLI::App& command, CLI::Option* position,
              const std::shared_ptr<AnchorOptions>& options) {
  CLI::Option* latitude = command.add_option(
      "--lat", options->latitude_deg,
      "Latitude, degrees north; with --lon, --alt and a datum instead of --position");
  CLI::Option* longitude = command.add_option("--lon", options->longitude_deg, "Degrees east");
  CLI::Option* altitude =
      command.add_option("--alt", options->altitude_m, "Metres above the ellipsoid (WGS 84)");
  for (CLI::Option* one : {latitude, longitude, altitude}) {
    one->excludes(position);
    for (CLI::Option* other : {latitude, longitude, altitude}) {
      if (one != other) one->needs(other);
    }
  }
}

void AddSet(CLI::App& anchor, Action& action) {
  auto options = std::make_shared<AnchorOptions>();
  CLI::App* command = Add(anchor, "set", "Give the position of a submap", action, options, &RunSet);
  command
      ->add_option("SUBMAP", options->target,
                   "SESSION/INDEX, or ROBOT: the newest submap of its newest session")
      ->required();
  CLI::Option* position =
      command
          ->add_option("--position", options->position,
                       "X Y Z, m: position of the sensor at the submap's first keyframe")
          ->expected(3);
  AddPlace(*command, position, options);
  CLI::Option* rpy =
      command
          ->add_option("--rpy-deg", options->rpy_deg, "ROLL PITCH YAW of the sensor there, degrees")
          ->expected(3);
  CLI::Option* sigma = AddSigmas(*command, options);
  rpy->needs(sigma);
  sigma->needs(rpy);
}

}  // namespace

void AddAnchor(CLI::App& app, Action& action) {
  CLI::App* anchor =
      app.add_subcommand("anchor", "Anchors: positions of submaps from an outside source");
  anchor->require_subcommand(1);
  AddSet(*anchor, action);
  {
    auto options = std::make_shared<AnchorOptions>();
    CLI::App* command = Add(*anchor, "remove", "Remove an anchor", action, options, &RunRemove);
    command->add_option("SUBMAP", options->target, "SESSION/INDEX")->required();
  }
  Add(*anchor, "list", "All anchors", action, std::make_shared<AnchorOptions>(), &RunList);
  {
    auto options = std::make_shared<AnchorOptions>();
    CLI::App* command =
        Add(*anchor, "import",
            "Anchor submaps at their poses in a graph that another program has optimised", action,
            options, &RunImport);
    command->add_option("FILE", options->file, "From `isthmus graph --g2o`, with its comments")
        ->required();
    AddSigmas(*command, options);
  }
}

}  // namespace isthmus::cli
