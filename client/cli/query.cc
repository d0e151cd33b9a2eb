// isthmus query: the points of a part of the merged map.
#include <absl/strings/numbers.h>
#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>
#include <absl/strings/str_split.h>

#include <algorithm>

#include "client/cli/commands.h"
#include "client/cli/region_reader.h"
#include "client/console/exit_code.h"
#include "core/formats/map_writer.h"
#include "core/io/file_io.h"

namespace isthmus::cli {
namespace {

struct QueryOptions {
  ServerOptions server;
  std::string box, sphere, robot, output;
  RegionQuery query;
};

// "1,2,3" as three numbers.
absl::StatusOr<std::vector<double>> Numbers(const std::string& text, size_t count,
                                            const char* option, const char* form) {
  std::vector<double> numbers;
  for (absl::string_view part : absl::StrSplit(text, ',')) {
    double value = 0;
    if (!absl::SimpleAtod(part, &value)) break;
    numbers.push_back(value);
  }
  if (numbers.size() == count &&
      std::count(text.begin(), text.end(), ',') == static_cast<long>(count) - 1) {
    return numbers;
  }
  return absl::InvalidArgumentError(absl::StrCat(option, " is ", form, ", not '", text, "'"));
}

absl::Status ParseRegion(const QueryOptions& options, RegionQuery& query) {
  if (!options.box.empty()) {
    const auto n = Numbers(options.box, 6, "--box", "x0,y0,z0,x1,y1,z1");
    if (!n.ok()) return n.status();
    const double* v = n->data();
    query.box = Box{{v[0], v[1], v[2]}, {v[3], v[4], v[5]}};
  }
  if (!options.sphere.empty()) {
    const auto n = Numbers(options.sphere, 4, "--sphere", "x,y,z,radius");
    if (!n.ok()) return n.status();
    query.sphere = {{(*n)[0], (*n)[1], (*n)[2]}, (*n)[3]};
  }
  query.robot = RobotId(options.robot);
  return absl::OkStatus();
}

int Run(QueryOptions options) {
  if (absl::Status status = ParseRegion(options, options.query); !status.ok()) {
    return Fail(kUsage, status);
  }
  const auto client = Connect(options.server);
  if (!client.ok()) return FailServer(client.status());
  const auto region = ReadRegion(**client, options.query);
  if (!region.ok()) return FailServer(region.status());
  constexpr auto kEncoding = formats::PcdEncoding::kBinary;
  const absl::Status written = io::WriteFile(
      options.output, formats::PcdMapHeader(region->points.size(), kEncoding, region->robots) +
                          formats::PcdMapChunk(region->points, kEncoding));
  if (!written.ok()) return Fail(kFailed, written);
  absl::PrintF("%s: %d points, revision %d\n", options.output, region->points.size(),
               region->revision);
  return kOk;
}

}  // namespace

void AddQuery(CLI::App& app, Action& action) {
  auto options = std::make_shared<QueryOptions>();
  CLI::App* command = app.add_subcommand("query", "Points of a part of the merged map as PCD");
  AddServerOptions(*command, options->server);
  CLI::Option* box =
      command->add_option("--box", options->box, "x0,y0,z0,x1,y1,z1 in the map frame");
  command->add_option("--sphere", options->sphere, "x,y,z,radius in the map frame")->excludes(box);
  command->add_option("--robot", options->robot, "Points of this robot only");
  command->add_option("--component", options->query.component, "0 is the largest")
      ->capture_default_str();
  command
      ->add_option("--resolution", options->query.resolution_m,
                   "One point per voxel of so many metres; 0: as composed")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  command->add_option("-o,--output", options->output, "FILE.pcd")->required();
  command->callback([options, &action] { action = [options] { return Run(*options); }; });
}

}  // namespace isthmus::cli
