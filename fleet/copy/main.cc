// isthmus-fleet: `isthmus copy`, which takes a map from a folder to a PostgreSQL database, back, or
// to another of either. `isthmus` becomes this program for it. See docs/postgresql.md.

#include <memory>
#include <string>

#include "client/console/command.h"
#include "client/console/console.h"
#include "client/console/exit_code.h"
#include "client/console/json.h"
#include "client/console/offline_commands.h"
#include "client/console/say.h"
#include "fleet/copy/copy_map.h"

namespace isthmus::cli {
namespace {

struct CopyArguments {
  storage::MapPlace from, to;
  bool json = false;
};

int RunCopy(const CopyArguments& options) {
  const auto report = storage::CopyMap(options.from, options.to);
  const bool is_input =
      absl::IsNotFound(report.status()) || absl::IsAlreadyExists(report.status()) ||
      absl::IsFailedPrecondition(report.status()) || absl::IsInvalidArgument(report.status());
  if (is_input) return FailInput(report.status());
  if (!report.ok()) return Fail(kFailed, report.status());
  if (options.json) {
    Print(Json{{"schema", report->schema},
               {"records", report->records},
               {"sessions", report->sessions},
               {"submaps", report->submaps},
               {"scans", report->scans},
               {"matches", report->matches},
               {"revisions", report->revisions},
               {"events", report->events}});
  } else {
    Say("%d records copied and read back: %d sessions, %d submaps, %d scans, %d matches, %d "
        "revisions, %d events\n",
        report->records, report->sessions, report->submaps, report->scans, report->matches,
        report->revisions, report->events);
  }
  return kOk;
}

void AddCopy(CLI::App& app, Action& action) {
  auto options = std::make_shared<CopyArguments>();
  CLI::App* command = AddOfflineCommand(app, "copy");
  command->add_option("FROM", options->from.where, "Map folder, or postgresql://USER@HOST/DATABASE")
      ->required();
  command->add_option("TO", options->to.where, "Map folder or database without a map")->required();
  command->add_option("--from-site", options->from.site,
                      "Site of the map in the database FROM; without it the default one");
  command->add_option("--to-site", options->to.site, "The same for TO");
  command->add_option("--to-bucket", options->to.bucket,
                      "Bucket of an object store for the large values of the database TO: "
                      "https://HOST/BUCKET/PREFIX?region=REGION");
  command->add_flag("--json", options->json, "Summary as JSON");
  command->callback([options, &action] { action = [options] { return RunCopy(*options); }; });
}

}  // namespace
}  // namespace isthmus::cli

int main(int argc, char** argv) {
  using namespace isthmus::cli;
  CLI::App app{"Commands of isthmus for maps in databases.", "isthmus"};
  constexpr AddCommand kCommands[] = {AddCopy};
  return RunCommandLine(app, kCommands, argc, argv);
}
