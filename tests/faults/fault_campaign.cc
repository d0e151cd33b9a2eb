// The campaigns of tests/faults at any length; see docs/durability.md.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <string>
#include <vector>

#include "tests/faults/client_kills.h"
#include "tests/faults/full_disk.h"
#include "tests/faults/harness/damage.h"
#include "tests/faults/link_faults.h"
#include "tests/faults/server_kills.h"

namespace isthmus::faults {
namespace {

struct Arguments {
  int kills = 0, client_kills = 0, damages = 0, full_disks = 0;
  double outage_s = 0, period_s = 0.1;
  Setup setup = {.server = ISTHMUS_SERVER, .robot = FAULT_ROBOT, .folder = ""};
};

int Run(const Arguments& arguments) {
  std::vector<Report> reports;
  if (arguments.kills > 0) {
    ServerKillOptions options;
    options.kills = arguments.kills;
    reports.push_back(KillServer(arguments.setup, options));
  }
  if (arguments.client_kills > 0) {
    ClientKillOptions options;
    options.kills = arguments.client_kills;
    reports.push_back(KillClients(arguments.setup, options));
  }
  if (arguments.outage_s > 0) {
    LinkFaultOptions options;
    options.outage_s = options.slow_s = arguments.outage_s;
    options.resets = static_cast<int>(2 * arguments.outage_s);
    options.period_s = arguments.period_s;
    reports.push_back(SpoilLinks(arguments.setup, options));
  }
  if (arguments.full_disks > 0) {
    FullDiskOptions options;
    options.times = arguments.full_disks;
    reports.push_back(FillDisk(arguments.setup, options));
  }
  if (arguments.damages > 0) {
    reports.push_back(DamageFolders(arguments.setup, arguments.damages));
  }
  std::fputs(ToMarkdown(reports).c_str(), stdout);
  for (const Report& report : reports) {
    if (!report.broken.empty()) return 1;
  }
  return 0;
}

}  // namespace
}  // namespace isthmus::faults

int main(int argc, char** argv) {
  isthmus::faults::Arguments arguments;
  CLI::App app("Breaks the promise of docs/durability.md on purpose.", "fault_campaign");
  app.add_option("--kills", arguments.kills, "kill -9 of the server, so many times");
  app.add_option("--client-kills", arguments.client_kills, "kill -9 of the robots' programs");
  app.add_option("--outage", arguments.outage_s, "Bad links, with outages of so many seconds");
  app.add_option("--period", arguments.period_s, "Seconds between two scans, with --outage")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  app.add_option("--full-disks", arguments.full_disks, "A full disk, so many times");
  app.add_option("--damages", arguments.damages, "Damaged folders, each kind with so many seeds");
  app.add_option("--seed", arguments.setup.seed, "Of all that is random")->capture_default_str();
  app.add_option("--robots", arguments.setup.robots, "How many stream")
      ->check(CLI::Range(1, 4))
      ->capture_default_str();
  app.add_option("--server", arguments.setup.server, "The isthmus-server to be tried")
      ->capture_default_str();
  app.add_option("--folder", arguments.setup.folder, "For maps and logs; what is there goes")
      ->required();
  CLI11_PARSE(app, argc, argv);
  try {
    return isthmus::faults::Run(arguments);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "fault_campaign: %s\n", error.what());
    return 2;
  }
}
