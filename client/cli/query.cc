// isthmus query: the points of a part of the merged map.
#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>
#include <absl/time/time.h>

#include <cstdint>
#include <string>
#include <vector>

#include "client/cli/region_options.h"
#include "client/console/age.h"
#include "client/console/command.h"
#include "client/console/exit_code.h"
#include "client/console/numbers.h"
#include "client/console/output_name.h"
#include "client/console/region_reader.h"
#include "client/console/say.h"
#include "core/formats/map_writer.h"
#include "core/io/output_file.h"

namespace isthmus::cli {
namespace {

struct QueryOptions {
  ServerOptions server;
  RegionOptions region;
  std::vector<std::string> sessions;
  std::string seen_since, seen_until, output;
  double rounding_m = 0;
  bool with_draco = false;
};

absl::Status TakeMoment(const std::string& text, const char* option, int64_t* ns) {
  if (text.empty()) return absl::OkStatus();
  const auto moment = ParseMoment(text);
  if (!moment) {
    return absl::InvalidArgumentError(
        absl::StrCat(option, " \"", text, "\" is neither a span (45m, 12h, 30d, 2w), a day ",
                     "(2026-05-01) nor a time (2026-05-01T12:00:00Z)"));
  }
  *ns = absl::ToUnixNanos(*moment);
  return absl::OkStatus();
}

absl::StatusOr<RegionQuery> QueryOf(const QueryOptions& options) {
  auto query = ParseRegion(options.region);
  if (!query.ok()) return query;
  for (const std::string& session : options.sessions) query->sessions.emplace_back(session);
  absl::Status status = TakeMoment(options.seen_since, "--seen-since", &query->seen_from_ns);
  if (status.ok()) status = TakeMoment(options.seen_until, "--seen-until", &query->seen_to_ns);
  if (!status.ok()) return status;
  if (options.rounding_m > 0) query->rounding_m = options.rounding_m;
  query->with_draco = options.with_draco;
  return query;
}

int Run(const QueryOptions& options) {
  const auto query = QueryOf(options);
  if (!query.ok()) return Fail(kUsage, query.status());
  if (absl::Status status = io::CheckOutput(options.output); !status.ok()) return FailInput(status);
  const auto client = Connect(options.server);
  if (!client.ok()) return FailServer(client.status());
  const auto region = ReadRegion(**client, *query);
  if (!region.ok()) return FailServer(region.status());
  SayWhichMap(**client, query->component);
  constexpr auto kEncoding = formats::PcdEncoding::kBinary;
  const absl::Status written = io::WriteOutput(
      options.output, formats::PcdMapHeader(region->points.size(), kEncoding, region->robots) +
                          formats::PcdMapChunk(region->points, kEncoding));
  if (!written.ok()) return Fail(kFailed, written);
  if (io::IsStandardOutput(options.output)) return kOk;
  const std::string thinned = query->max_points > 0 && region->resolution_m > 0
                                  ? absl::StrFormat(", one per %g m", region->resolution_m)
                                  : std::string();
  Say("%s: %d points%s, revision %d\n", options.output, region->points.size(), thinned,
      region->revision);
  return kOk;
}

}  // namespace

void AddQuery(CLI::App& app, Action& action) {
  auto options = std::make_shared<QueryOptions>();
  CLI::App* command = app.add_subcommand("query", "The points of a part of the merged map as PCD");
  AddServerOptions(*command, options->server);
  AddRegionOptions(*command, options->region);
  command
      ->add_option("--resolution", options->region.query.resolution_m,
                   "One point per voxel with this edge, metres; 0: as composed")
      ->check(NotNegative())
      ->capture_default_str();
  command
      ->add_option("--max-points", options->region.query.max_points,
                   "At most this many points, at the finest resolution that allows it")
      ->check(Positive());
  command->add_option("--session", options->sessions,
                      "Only points that this session saw last; may be repeated");
  command->add_option("--seen-since", options->seen_since,
                      "Only points seen since then: 45m, 12h, 30d, 2w, a day, a time");
  command->add_option("--seen-until", options->seen_until, "Only points last seen before then");
  command
      ->add_option("--rounding", options->rounding_m,
                   "Compress coordinates to this precision, metres; 0: no compression")
      ->check(Between(0.0, 0.1));
  command->add_flag("--draco", options->with_draco, "Compress with Draco, to --rounding or 1 mm");
  command->add_option("-o,--output", options->output, "FILE.pcd; - for stdout")
      ->check(OutputNamed({".pcd"}))
      ->required();
  command->callback([options, &action] { action = [options] { return Run(*options); }; });
}

}  // namespace isthmus::cli
