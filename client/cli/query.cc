// isthmus query: the points of a part of the merged map.
#include <absl/strings/str_format.h>

#include "client/cli/commands.h"
#include "client/cli/region_options.h"
#include "client/cli/region_reader.h"
#include "client/console/exit_code.h"
#include "core/formats/map_writer.h"
#include "core/io/output_file.h"

namespace isthmus::cli {
namespace {

struct QueryOptions {
  ServerOptions server;
  RegionOptions region;
  std::string output;
};

int Run(const QueryOptions& options) {
  const auto query = ParseRegion(options.region);
  if (!query.ok()) return Fail(kUsage, query.status());
  if (absl::Status status = io::CheckOutput(options.output); !status.ok()) return FailInput(status);
  const auto client = Connect(options.server);
  if (!client.ok()) return FailServer(client.status());
  const auto region = ReadRegion(**client, *query);
  if (!region.ok()) return FailServer(region.status());
  constexpr auto kEncoding = formats::PcdEncoding::kBinary;
  const absl::Status written = io::WriteOutput(
      options.output, formats::PcdMapHeader(region->points.size(), kEncoding, region->robots) +
                          formats::PcdMapChunk(region->points, kEncoding));
  if (!written.ok()) return Fail(kFailed, written);
  if (io::IsStandardOutput(options.output)) return kOk;
  absl::PrintF("%s: %d points, revision %d\n", options.output, region->points.size(),
               region->revision);
  return kOk;
}

}  // namespace

void AddQuery(CLI::App& app, Action& action) {
  auto options = std::make_shared<QueryOptions>();
  CLI::App* command = app.add_subcommand("query", "Points of a part of the merged map as PCD");
  AddServerOptions(*command, options->server);
  AddRegionOptions(*command, options->region);
  command
      ->add_option("--resolution", options->region.query.resolution_m,
                   "One point per voxel of so many metres; 0: as composed")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  command->add_option("-o,--output", options->output, "FILE.pcd; - for stdout")->required();
  command->callback([options, &action] { action = [options] { return Run(*options); }; });
}

}  // namespace isthmus::cli
