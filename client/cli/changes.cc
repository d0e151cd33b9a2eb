// isthmus changes: what came and went since a time or a revision.
#include "client/exports/changes.h"

#include <absl/strings/numbers.h>
#include <absl/strings/str_cat.h>
#include <absl/strings/str_join.h>
#include <absl/time/time.h>

#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "api/convert/changed_volumes.h"
#include "client/cli/changes_picture.h"
#include "client/cli/moves_text.h"
#include "client/cli/region_options.h"
#include "client/cli/site_reader.h"
#include "client/console/age.h"
#include "client/console/command.h"
#include "client/console/exit_code.h"
#include "client/console/json.h"
#include "client/console/numbers.h"
#include "client/console/output_name.h"
#include "client/console/say.h"
#include "core/geometry/angles.h"
#include "core/io/output_file.h"

namespace isthmus::cli {
namespace {

struct ChangesOptions {
  ServerOptions server;
  RegionOptions region;
  std::string since, ply, picture, geojson;
  double smallest_m = 0.3;
  uint32_t limit = 1000;
  bool json = false;
};

absl::StatusOr<ChangeQuery> QueryOf(const ChangesOptions& options, const RegionQuery& region) {
  ChangeQuery query;
  int64_t revision = 0;
  if (absl::SimpleAtoi(options.since, &revision)) {
    query.since_revision = revision;
  } else if (const auto moment = ParseMoment(options.since)) {
    query.since_ns = absl::ToUnixNanos(*moment);
  } else {
    return absl::InvalidArgumentError(
        absl::StrCat("--since \"", options.since,
                     "\" is neither a span (45m, 12h, 30d, 2w), a day (2026-05-01), a time "
                     "(2026-05-01T12:00:00Z) nor the number of a revision"));
  }
  query.component = region.component;
  query.box = region.box;
  query.sphere = region.sphere;
  query.shape = region.shape;
  query.smallest_m = options.smallest_m;
  query.max_volumes = options.limit;
  query.wants_points = !options.ply.empty();
  return query;
}

std::string NamesOf(const std::vector<RobotId>& robots) {
  const auto add = [](std::string* out, const RobotId& robot) {
    absl::StrAppend(out, robot.value());
  };
  return absl::StrJoin(robots, ",", add);
}

double YawDeg(const ChangedVolume& volume) {
  const Eigen::Matrix3d R = volume.T_map_box.RotationMatrix();
  return std::atan2(R(1, 0), R(0, 0)) / kRadPerDeg;
}

void PrintJson(const ChangeList& changes) {
  v1::FindChangesResponse response;
  response.set_revision(changes.revision);
  response.set_submaps_before(changes.submaps_before);
  response.set_submaps_after(changes.submaps_after);
  response.set_left_out(changes.left_out);
  for (const ChangedVolume& volume : changes.volumes) {
    *response.add_volumes() = convert::ToMessage(volume);
  }
  Json out = ToJson(response);
  for (size_t i = 0; i < changes.volumes.size(); ++i) {
    out["volumes"][i]["yaw_deg"] = YawDeg(changes.volumes[i]);
  }
  Print(out);
}

void PrintTable(const ChangeList& changes) {
  size_t came = 0;
  for (const ChangedVolume& volume : changes.volumes) came += volume.came ? 1 : 0;
  Say("revision %d, %d submaps before and %d since: %d volumes came, %d went\n", changes.revision,
      changes.submaps_before, changes.submaps_after, came, changes.volumes.size() - came);
  if (changes.left_out > 0) {
    Say("%d smaller ones are left out: --limit shows more\n", changes.left_out);
  }
  if (changes.volumes.empty()) return;
  Say("%-4s  %26s  %18s  %4s  %6s  %5s  %-19s  %-19s  %s\n", "", "middle x, y, z (m)",
      "length, width, height", "yaw", "points", "prob.", "last seen (UTC)", "not there (UTC)",
      "seen by; missed by");
  for (const ChangedVolume& volume : changes.volumes) {
    const Eigen::Vector3d at = volume.T_map_box.translation();
    const auto yaw = static_cast<int>(std::lround(YawDeg(volume)));
    Say("%-4s  %8.2f %8.2f %8.2f  %7.2f %6.2f %6.2f  %4d  %6d  %5.3f  %-19s  %-19s  %s; %s\n",
        volume.came ? "came" : "went", at.x(), at.y(), at.z(), volume.size.x(), volume.size.y(),
        volume.size.z(), yaw, volume.points, volume.probability, TimeText(volume.seen_last_ns),
        TimeText(volume.missing_ns), NamesOf(volume.seen_by), NamesOf(volume.missed_by));
  }
}

using SiteOrNone = std::optional<earth::Site>;

// The map's place on the Earth, if it is needed; FailedPrecondition if it is not known.
absl::StatusOr<SiteOrNone> SiteFor(client::Client& client, const ChangesOptions& options) {
  if (options.geojson.empty()) return SiteOrNone();
  auto site = ReadSite(client, options.region.query.component);
  if (site.ok()) return *std::move(site);
  if (!absl::IsFailedPrecondition(site.status())) return site.status();
  return absl::FailedPreconditionError(
      absl::StrCat("GeoJSON needs coordinates on the Earth (--json and --ply are in metres), and ",
                   site.status().message()));
}

// The files that were asked for.
absl::Status WriteFiles(client::Client& client, const ChangesOptions& options,
                        const RegionQuery& region, const ChangeList& changes,
                        const SiteOrNone& site) {
  absl::Status status;
  if (!options.ply.empty()) {
    status = io::WriteOutput(options.ply, exports::FormatChangesPly(changes));
  }
  if (status.ok() && site) {
    status = io::WriteOutput(options.geojson, exports::FormatChangesGeoJson(changes, *site));
  }
  if (status.ok() && !options.picture.empty()) {
    status = DrawChanges(client, region, changes, options.picture);
  }
  return status;
}

int Run(const ChangesOptions& options) {
  const auto region = ParseRegion(options.region);
  if (!region.ok()) return Fail(kUsage, region.status());
  const auto query = QueryOf(options, *region);
  if (!query.ok()) return Fail(kUsage, query.status());
  bool prints = true;  // Standard output is not taken by a file.
  for (const std::string& path : {options.ply, options.geojson, options.picture}) {
    if (path.empty()) continue;
    if (absl::Status status = io::CheckOutput(path); !status.ok()) return FailInput(status);
    prints = prints && !io::IsStandardOutput(path);
  }
  const auto client = Connect(options.server);
  if (!client.ok()) return FailServer(client.status());
  const auto site = SiteFor(**client, options);  // Before all the work.
  if (!site.ok()) return FailServer(site.status());
  const auto changes = (*client)->FindChanges(*query);
  if (!changes.ok()) {
    // A revision that is no longer kept is as unknown as one that never was.
    return absl::IsOutOfRange(changes.status()) ? Fail(kUnknown, changes.status())
                                                : FailServer(changes.status());
  }
  const absl::Status written = WriteFiles(**client, options, *region, *changes, *site);
  if (!written.ok()) return Fail(kFailed, written);
  if (!prints) return kOk;
  if (options.json) {
    PrintJson(*changes);
  } else {
    PrintTable(*changes);
  }
  return kOk;
}

}  // namespace

void AddChanges(CLI::App& app, Action& action) {
  auto options = std::make_shared<ChangesOptions>();
  CLI::App* command = app.add_subcommand(
      "changes", "Volumes that came and went between an earlier state of the map and now");
  AddServerOptions(*command, options->server);
  command
      ->add_option("--since", options->since,
                   "A span back from now (45m, 12h, 30d, 2w), a day or a time: scans before it are "
                   "compared with later ones; or the number of a revision: the map of that "
                   "revision is compared with later submaps")
      ->required();
  AddPlaceOptions(*command, options->region);
  command
      ->add_option("--smallest", options->smallest_m, "Shortest longest edge of a volume, metres")
      ->check(Positive())
      ->capture_default_str();
  command->add_option("--limit", options->limit, "Show at most this many volumes, the largest")
      ->check(CLI::Range(1, 10000))
      ->capture_default_str();
  command->add_flag("--json", options->json, "As JSON");
  command->add_option("--ply", options->ply, "The volumes' points in colour, FILE.ply")
      ->check(OutputNamed({".ply"}));
  command
      ->add_option("--geojson", options->geojson,
                   "The volumes' outlines on the Earth, FILE.geojson; needs a datum")
      ->check(OutputNamed({".geojson", ".json"}));
  command
      ->add_option("--picture", options->picture, "The map from above with the volumes, FILE.png")
      ->check(OutputNamed({".png"}));
  command->callback([options, &action] { action = [options] { return Run(*options); }; });
}

}  // namespace isthmus::cli
