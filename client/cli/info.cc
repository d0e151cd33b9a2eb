// isthmus info: what a recording holds, and how to use it.
#include <limits>

#include "client/console/command.h"
#include "client/console/console.h"
#include "client/console/exit_code.h"
#include "client/console/json.h"
#include "client/console/recording_options.h"
#include "client/console/recording_report.h"

namespace isthmus::cli {
namespace {

struct InfoArguments {
  std::string path;
  RecordingOptions recording;
  bool all = false, json = false;
};

int Run(const InfoArguments& options) {
  constexpr uint64_t kFirstScans = 200;
  RecordingReport report;
  {
    Progress progress("scans", 0);
    uint64_t scans = 0;
    auto read = ReadReport(options.path, options.recording.read,
                           options.all ? std::numeric_limits<uint64_t>::max() : kFirstScans,
                           [&] { progress.Update(++scans); });
    if (!read.ok()) return FailInput(read.status());
    report = *std::move(read);
  }
  if (options.json) {
    Print(ToJson(report));
  } else {
    PrintText(report);
  }
  return report.command.empty() ? kInput : kOk;
}

}  // namespace

void AddInfo(CLI::App& app, Action& action) {
  auto options = std::make_shared<InfoArguments>();
  CLI::App* command =
      app.add_subcommand("info", "Show the contents of a recording, and how to push it");
  command->add_option("PATH", options->path, "Folder of scans, .bag, .mcap, .db3 or .pcap")
      ->required();
  AddReadOptions(*command, options->recording.read);
  command->add_flag("--all", options->all,
                    "Read the whole recording, not only the first 200 scans");
  command->add_flag("--json", options->json, "As JSON");
  command->callback([options, &action] { action = [options] { return Run(*options); }; });
}

}  // namespace isthmus::cli
