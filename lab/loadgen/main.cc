// isthmus-loadgen: many robots and readers at one server, and how it held up.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <iostream>
#include <optional>
#include <string>
#include <vector>

#include "client/console/console.h"
#include "client/console/exit_code.h"
#include "client/console/interruption.h"
#include "client/console/numbers.h"
#include "core/command_line/checks.h"
#include "lab/loadgen/drives.h"
#include "lab/loadgen/limits.h"
#include "lab/loadgen/load_report.h"
#include "lab/loadgen/load_run.h"

namespace isthmus::loadgen {
namespace {

struct Arguments {
  LoadOptions load;
  SimulatedDrives simulated;
  std::vector<std::string> recordings;
  std::string link = "none";
  bool keep_newest = false;
  bool json = false;
};

void AddMisbehavingClients(CLI::App& app, MisbehavingClientOptions& misbehaving) {
  app.add_option("--half-open", misbehaving.half_open, "Connections without any bytes")
      ->check(CLI::Range(0, 10'000))
      ->capture_default_str();
  app.add_option("--slow-writers", misbehaving.slow_writers,
                 "Connections that send one byte per second")
      ->check(CLI::Range(0, 10'000))
      ->capture_default_str();
  app.add_option("--slow-readers", misbehaving.slow_readers,
                 "Queries of the whole map that read one piece per second")
      ->check(CLI::Range(0, 1000))
      ->capture_default_str();
  app.add_option("--malformed", misbehaving.malformed_per_s,
                 "Streams per second that begin with noise")
      ->check(cli::Between(0.0, 1e4))
      ->capture_default_str();
}

void AddOptions(CLI::App& app, Arguments& arguments) {
  LoadOptions& load = arguments.load;
  app.add_option("recordings", arguments.recordings,
                 "Recorded drives to send in turn; without them simulated ones");
  app.add_option("--server", load.server, "host:port of the server")
      ->envname("ISTHMUS_SERVER")
      ->capture_default_str();
  app.add_option("--robots", load.robots, "Robots that send scans")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  app.add_option("--seconds", load.seconds, "Length of the run")
      ->check(cli::Between(1.0, 1e6))
      ->capture_default_str();
  app.add_option("--rate", load.rate_hz, "Scans per second of each robot")
      ->check(cli::Between(0.1, 1000.0))
      ->capture_default_str();
  app.add_option("--jitter", load.jitter_s, "Greatest delay of scans, seconds")
      ->check(cli::Between(0.0, 10.0))
      ->capture_default_str();
  app.add_option("--link", arguments.link, "The robots' links: none (perfect), wifi or 4g")
      ->capture_default_str();
  app.add_flag("--keep-newest", arguments.keep_newest,
               "If the server falls behind, it skips scans instead of slowing robots down");
  app.add_option("--readers", load.readers, "Clients that read the map meanwhile")
      ->check(CLI::Range(0, 1000))
      ->capture_default_str();
  app.add_option("--reader-period", load.reader_period_s, "Seconds between a reader's queries")
      ->check(cli::Between(0.001, 1e6))
      ->capture_default_str();
  app.add_option("--idle", load.idle, "Robots that only keep their link open")
      ->check(CLI::Range(0, 10'000))
      ->capture_default_str();
  app.add_option("--dense", load.dense, "Further robots, with scans of --dense-points")
      ->check(CLI::Range(0, 100))
      ->capture_default_str();
  app.add_option("--dense-points", load.dense_points, "Points of a scan of --dense robots")
      ->check(CLI::Range(1, 10'000'000))
      ->capture_default_str();
  app.add_option("--backfill", load.backfill,
                 "Further robots that send a drive as fast as the server accepts it")
      ->check(CLI::Range(0, 1000))
      ->capture_default_str();
  app.add_option("--empty", load.empty, "Sessions without any scans")
      ->check(CLI::Range(0, 100'000))
      ->capture_default_str();
  app.add_option("--knocks", load.knocks_per_s, "Connections per second that are dropped at once")
      ->check(cli::Between(0.0, 1e5))
      ->capture_default_str();
  AddMisbehavingClients(app, load.misbehaving);
  app.add_option("--world", arguments.simulated.world, "Of simulated drives")
      ->capture_default_str();
  app.add_option("--sensor", arguments.simulated.sensor, "Of simulated drives")
      ->capture_default_str();
  app.add_option("--seed", load.seed, "Seed of worlds, drives and faults")
      ->check(cli::NotNegative())
      ->capture_default_str();
  app.add_option("--prefix", load.prefix, "Prefix of the robots' names")->capture_default_str();
  app.add_option("--server-pid", load.server_pid,
                 "Process of the server on this machine; its CPU, memory and threads are reported");
  app.add_option("--data", load.data_folder, "Folder of that server; its growth is reported");
  app.add_flag("--json", arguments.json, "Report as JSON");
}

absl::StatusOr<Drives> MakeDrives(const Arguments& arguments) {
  const LoadOptions& load = arguments.load;
  if (!arguments.recordings.empty()) {
    return ReadDrives(arguments.recordings, DriveSeconds(load, arguments.recordings.size()));
  }
  SimulatedDrives simulated = arguments.simulated;
  simulated.drives = std::min(load.robots, kMaxDrives);
  simulated.seconds = DriveSeconds(load, static_cast<size_t>(simulated.drives));
  simulated.seed = load.seed;
  std::fprintf(stderr, "simulating %d drives of %.0f s\n", simulated.drives, simulated.seconds);
  return SimulateDrives(simulated);
}

int Run(Arguments arguments) {
  const auto link = FindLinkProfile(arguments.link);
  if (!link.ok()) return cli::Fail(cli::kUsage, link.status());
  arguments.load.link = *link;
  if (arguments.keep_newest) arguments.load.when_behind = WhenBehind::kKeepNewest;
  const cli::Interruption interruption([] {});
  const auto drives = MakeDrives(arguments);
  if (!drives.ok()) return cli::FailInput(drives.status());
  const auto total = static_cast<uint64_t>(arguments.load.robots * arguments.load.seconds *
                                           arguments.load.rate_hz);
  std::optional<cli::Progress> progress;
  progress.emplace("scans", total);
  const auto result = RunLoad(arguments.load, *drives, [&](uint64_t acknowledged) {
    progress->Update(acknowledged);
    return !interruption.happened();
  });
  progress.reset();
  if (!result.ok()) return cli::FailServer(result.status());
  if (arguments.json) {
    cli::Print(ToJson(*result));
  } else {
    std::fputs(ToText(*result).c_str(), stdout);
  }
  return AllAnswered(*result) ? cli::kOk : cli::kFailed;
}

}  // namespace
}  // namespace isthmus::loadgen

int main(int argc, char** argv) {
  using namespace isthmus::loadgen;
  CLI::App app(
      "Sends scans of many robots to an Isthmus server at a steady rate, with readers and "
      "misbehaving clients beside them. Reports the time to each acknowledgement, lost scans, and "
      "the server's use of resources.",
      "isthmus-loadgen");
  Arguments arguments;
  AddOptions(app, arguments);
  const std::vector<std::string> words = isthmus::Words(argc, argv);
  absl::Status status = isthmus::CheckText(words);
  if (!status.ok()) return isthmus::cli::Fail(isthmus::cli::kUsage, status);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error, std::cout, std::cerr) == 0 ? isthmus::cli::kOk : isthmus::cli::kUsage;
  }
  status = isthmus::CheckValues(words, app);
  if (!status.ok()) return isthmus::cli::Fail(isthmus::cli::kUsage, status);
  return Run(std::move(arguments));
}
