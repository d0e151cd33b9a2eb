// isthmus export: the merged map as files for other programs.
#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>

#include <filesystem>
#include <map>
#include <optional>
#include <vector>

#include "client/cli/grid_export.h"
#include "client/cli/region_options.h"
#include "client/cli/site_reader.h"
#include "client/console/command.h"
#include "client/console/console.h"
#include "client/console/exit_code.h"
#include "client/console/json.h"
#include "client/console/numbers.h"
#include "client/console/output_name.h"
#include "client/console/region_reader.h"
#include "client/console/say.h"
#include "client/exports/cloud_files.h"
#include "client/exports/mcap_file.h"
#include "client/exports/tracks.h"
#include "core/earth/tracks.h"
#include "core/floors/limits.h"
#include "core/io/output_file.h"

namespace isthmus::cli {
namespace {

// Formats that the server writes.
const std::map<std::string, ExportFormat> kServerFormats = {
    {"pcd", ExportFormat::kPcdBinaryCompressed},
    {"pcd-compressed", ExportFormat::kPcdBinaryCompressed},
    {"pcd-binary", ExportFormat::kPcdBinary},
    {"pcd-ascii", ExportFormat::kPcdAscii},
    {"ply", ExportFormat::kPly},
    {"bt", ExportFormat::kOctoMapBinary},
    {"ot", ExportFormat::kOctoMapFull}};

struct ExportOptions {
  ServerOptions server;
  RegionOptions region;
  std::string format, output;
  std::vector<double> band;
  double tile_m = exports::kTileM;
  bool dropped = false, json = false;
};

using SaveExport = int (*)(client::Client&, const RegionQuery&, const ExportOptions&);

// Files of this computer that cannot be written and what the server refuses look alike here; what
// could be told of the files beforehand was.
int FailExport(const absl::Status& status) {
  return absl::IsAlreadyExists(status) ? FailInput(status) : FailServer(status);
}

int SaveServerFile(client::Client& client, const RegionQuery& query, const ExportOptions& options) {
  const ExportRequest request{.format = kServerFormats.at(options.format),
                              .component = query.component,
                              .resolution_m = query.resolution_m,
                              .box = query.box,
                              .sphere = query.sphere,
                              .shape = query.shape,
                              .robot = query.robot,
                              .dropped = options.dropped,
                              .classes = query.classes};
  absl::StatusOr<client::ExportSummary> summary;
  {
    Progress progress(options.output, 0);
    summary = client.ExportToFile(request, options.output,
                                  [&](uint64_t bytes) { progress.Update(bytes); });
  }
  if (!summary.ok()) return FailExport(summary.status());
  if (io::IsStandardOutput(options.output)) return kOk;
  if (options.json) {
    Print({{"file", options.output},
           {"revision", summary->revision},
           {"size", summary->size},
           {"crc32c", absl::StrFormat("%08x", summary->crc32c)}});
  } else {
    Say("%s: %s, revision %d, crc32c %08x\n", options.output, HumanBytes(summary->size),
        summary->revision, summary->crc32c);
  }
  return kOk;
}

int SaveCloud(client::Client& client, const RegionQuery& query, const ExportOptions& options) {
  const auto site = ReadSiteIfKnown(client, query.component);
  if (!site.ok()) return FailServer(site.status());
  absl::StatusOr<exports::CloudSummary> summary;
  {
    Progress bar("points", 0);
    const auto progress = [&bar](uint64_t points) { bar.Update(points); };
    if (options.format == "las") {
      summary = exports::WriteLas(client, query, *site, options.output, progress);
    } else if (options.format == "mcap") {
      summary = exports::WriteMcap(client, query, options.output, progress);
    } else {
      summary = exports::WriteTiles(client, query, *site, options.tile_m, options.output, progress);
    }
  }
  if (!summary.ok()) return FailExport(summary.status());
  if (io::IsStandardOutput(options.output)) return kOk;
  const std::string system =
      options.format == "las" && *site ? (*site)->UtmName() : std::string("map frame");
  if (options.json) {
    Print({{"file", options.output},
           {"revision", summary->revision},
           {"points", summary->points},
           {"files", summary->files},
           {"system", system}});
  } else {
    Say("%s: %d points%s, %s, revision %d\n", options.output, summary->points,
        options.format == "autoware" ? absl::StrCat(" in ", summary->files, " tiles") : "", system,
        summary->revision);
  }
  return kOk;
}

std::string SayRooms(const GridFile& file) {
  if (file.rooms) return absl::StrFormat("%d rooms, %d doors", *file.rooms, *file.doors);
  return "too large to look for rooms: give larger cells with --resolution, or a --box";
}

int SaveGrids(client::Client& client, const RegionQuery& query, const ExportOptions& options) {
  GridRequest request{query, std::nullopt, options.output};
  if (query.resolution_m == 0) request.query.resolution_m = floors::kGridCellM;
  if (options.band.size() == 2) {
    request.band = floors::HeightBand{options.band[0], options.band[1]};
  }
  const std::filesystem::path output(options.output);
  if (output.extension() == ".pgm" || output.extension() == ".yaml") {
    request.name = std::filesystem::path(output).replace_extension().string();
  }
  const auto files = WriteGrids(client, request);
  if (!files.ok()) return FailExport(files.status());
  Json out = Json::array();
  for (const GridFile& file : *files) {
    out.push_back({{"file", file.name},
                   {"width", file.width},
                   {"height", file.height},
                   {"occupied", file.occupied},
                   {"free", file.free},
                   {"rooms", file.rooms ? Json(*file.rooms) : Json()},
                   {"doors", file.doors ? Json(*file.doors) : Json()},
                   {"lowest_m", file.lowest_m},
                   {"highest_m", file.highest_m}});
    if (options.json) continue;
    Say("%s: %d x %d cells, %d occupied, %d free; %s %.2f to %.2f m; %s\n", file.name, file.width,
        file.height, file.occupied, file.free, request.band ? "heights" : "sensors at",
        file.lowest_m, file.highest_m, SayRooms(file));
  }
  if (options.json) Print({{"maps", std::move(out)}});
  return kOk;
}

int SaveEarthTracks(client::Client& client, const RegionQuery& query,
                    const ExportOptions& options) {
  const auto site = ReadSite(client, query.component);
  if (!site.ok()) return FailServer(site.status());
  const auto tracks = exports::ReadTracks(client, query.component, query.robot);
  if (!tracks.ok()) return FailServer(tracks.status());
  const absl::Status written = io::WriteOutput(
      options.output, options.format == "kml" ? earth::FormatKml(*tracks, *site)
                                              : earth::FormatGeoJson(*tracks, *site));
  if (!written.ok()) return Fail(kFailed, written);
  if (io::IsStandardOutput(options.output)) return kOk;
  if (options.json) {
    Print({{"file", options.output}, {"tracks", tracks->size()}});
  } else {
    Say("%s: the trajectories of %d sessions\n", options.output, tracks->size());
  }
  return kOk;
}

const std::map<std::string, SaveExport> kLocalFormats = {
    {"las", &SaveCloud},  {"mcap", &SaveCloud},          {"autoware", &SaveCloud},
    {"nav2", &SaveGrids}, {"geojson", &SaveEarthTracks}, {"kml", &SaveEarthTracks}};

// The extensions of that format's files; a folder may have any name.
std::vector<std::string> ExtensionsOf(const std::string& format) {
  if (format == "autoware") return {};
  if (format == "nav2") return {".yaml", ".pgm"};
  if (format == "geojson") return {".geojson", ".json"};
  return {absl::StrCat(".", format.substr(0, format.find('-')))};
}

// The format that the extension of the output tells; empty: none.
std::string FormatOf(const std::string& output) {
  const std::string end = OutputExtension(output);
  for (const char* format : {"pcd", "ply", "bt", "ot", "las", "mcap", "nav2", "geojson", "kml"}) {
    for (const std::string& extension : ExtensionsOf(format)) {
      if (extension == end) return format;
    }
  }
  return "";
}

absl::Status CheckUse(const ExportOptions& options) {
  if (options.format.empty()) {
    return absl::InvalidArgumentError(absl::StrCat(
        "the name ", options.output, " does not tell the format: give one with --format"));
  }
  if (options.format != "autoware") {
    const absl::Status named = CheckOutputName(options.output, ExtensionsOf(options.format));
    if (!named.ok()) return named;
  } else if (const std::string file = FormatOf(options.output); !file.empty()) {
    return absl::InvalidArgumentError(absl::StrCat("autoware writes a folder, and ", options.output,
                                                   " is the name of a file: give another name"));
  }
  const bool is_many = options.format == "nav2" || options.format == "autoware";
  if (is_many && io::IsStandardOutput(options.output)) {
    return absl::InvalidArgumentError(
        absl::StrCat(options.format, " writes several files: give a name with -o"));
  }
  if (options.band.size() == 2 && !(options.band[0] < options.band[1])) {
    return absl::InvalidArgumentError("--height-band is LOW HIGH, the lower height first");
  }
  const RegionOptions& region = options.region;
  const bool has_shape =
      !(region.oriented_box.empty() && region.polygon.empty() && region.corridor.empty());
  if (options.format == "nav2" && (has_shape || !region.sphere.empty())) {
    return absl::InvalidArgumentError("a grid map can be cut by --box only");
  }
  const bool is_ways = options.format == "geojson" || options.format == "kml";
  if (is_ways && (has_shape || !region.box.empty() || !region.sphere.empty())) {
    return absl::InvalidArgumentError("trajectories are exported whole: give no part of the map");
  }
  const bool is_cloud = options.format == "las" || options.format == "ply" ||
                        options.format == "autoware" || options.format == "mcap" ||
                        options.format.starts_with("pcd");
  if (!region.classes.empty() && !is_cloud) {
    return absl::InvalidArgumentError(
        "--class needs the format of a cloud: --format las, ply, pcd, ...");
  }
  if (options.dropped && options.format != "ply" && !options.format.starts_with("pcd")) {
    return absl::InvalidArgumentError(
        "--dynamic needs the format of a cloud: --format ply, pcd, pcd-binary, ...");
  }
  return absl::OkStatus();
}

int RunExport(ExportOptions options) {
  if (options.format.empty()) options.format = FormatOf(options.output);
  if (absl::Status status = CheckUse(options); !status.ok()) return Fail(kUsage, status);
  const auto query = ParseRegion(options.region);
  if (!query.ok()) return Fail(kUsage, query.status());
  // A folder of tiles is looked at when it is made.
  if (options.format != "autoware") {
    const absl::Status usable = io::CheckOutput(options.output);
    if (!usable.ok()) return FailInput(usable);
  } else if (std::filesystem::exists(options.output)) {
    return FailInput(absl::AlreadyExistsError(
        absl::StrCat(options.output, " exists already: give a new folder, or remove it first")));
  } else if (absl::Status usable = io::CheckOutput(options.output); !usable.ok()) {
    return FailInput(usable);
  }
  const auto client = Connect(options.server);
  if (!client.ok()) return FailServer(client.status());
  const auto local = kLocalFormats.find(options.format);
  const SaveExport save = local == kLocalFormats.end() ? &SaveServerFile : local->second;
  const int code = save(**client, *query, options);
  if (code == kOk) SayWhichMap(**client, query->component);
  return code;
}

std::vector<std::string> FormatNames() {
  std::vector<std::string> names;
  names.reserve(kServerFormats.size() + kLocalFormats.size());
  for (const auto& item : kServerFormats) names.push_back(item.first);
  for (const auto& item : kLocalFormats) names.push_back(item.first);
  return names;
}

}  // namespace

void AddExport(CLI::App& app, Action& action) {
  auto options = std::make_shared<ExportOptions>();
  CLI::App* command = app.add_subcommand("export", "The merged map as files for other programs");
  AddServerOptions(*command, options->server);
  command
      ->add_option(
          "--format", options->format,
          "pcd (compressed), pcd-binary, pcd-ascii, ply, las (1.4), bt (OctoMap: free, occupied, "
          "unknown), ot (OctoMap with log-odds), nav2 (a .pgm and .yaml per floor, with its "
          "rooms), autoware (a "
          "folder of tiles), mcap (Foxglove), geojson, kml (trajectories, once there is a datum); "
          "without it the output's extension decides")
      ->check(CLI::IsMember(FormatNames()));
  AddRegionOptions(*command, options->region);
  command
      ->add_option("--resolution", options->region.query.resolution_m,
                   "Metres: voxels of clouds (0: as composed), leaves of OctoMaps (0: 0.2), cells "
                   "of nav2 (0: 0.05)")
      ->check(NotNegative())
      ->capture_default_str();
  command
      ->add_option("--height-band", options->band,
                   "nav2: LOW HIGH, one map of the space between these heights of the map, metres; "
                   "without it a map per floor")
      ->expected(2);
  command->add_option("--tile", options->tile_m, "autoware: edge of a tile, whole metres")
      ->check(Positive())
      ->capture_default_str();
  command->add_flag("--dynamic", options->dropped,
                    "ply, pcd: instead of the map, the points left out of it because later rays "
                    "went through them: people, cars, things taken away");
  command->add_option("-o,--output", options->output, "FILE; - for stdout")->required();
  command->add_flag("--json", options->json, "Summary as JSON");
  command->callback([options, &action] { action = [options] { return RunExport(*options); }; });
}

}  // namespace isthmus::cli
