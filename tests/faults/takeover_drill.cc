// The drill of servers with spares at any length; see docs/postgresql.md.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>
#include <string>

#include "tests/faults/takeover.h"
#include "tests/fleet/postgresql/postgres_server.h"

namespace isthmus::faults {
namespace {

struct Arguments {
  double minutes = 2;
  TakeoverOptions takeover = {.worker_program = ISTHMUS_WORKER, .cut_s = 20, .restarts = 2};
  Setup setup = {.server = ISTHMUS_SERVER, .robot = "", .folder = ""};
};

int Run(Arguments arguments) {
  const auto database = storage::PostgresServer::Start();
  if (database == nullptr) throw std::runtime_error("PostgreSQL does not start");
  arguments.setup.store = database->url();
  TakeoverOptions& takeover = arguments.takeover;
  takeover.faults = static_cast<int>(arguments.minutes * 60 / takeover.every_s);
  takeover.socket = database->folder() + "/.s.PGSQL.5432";
  takeover.restart_database = [&database] {
    database->Kill();
    database->StartAgain();
  };
  const Report report = TakeOver(arguments.setup, takeover);
  std::fputs(ToMarkdown({report}).c_str(), stdout);
  return report.broken.empty() && report.map.same_bits ? 0 : 1;
}

}  // namespace
}  // namespace isthmus::faults

int main(int argc, char** argv) {
  isthmus::faults::Arguments arguments;
  CLI::App app(
      "Kills, pauses and cuts off servers with spares, and kills workers, while robots stream.",
      "takeover_drill");
  app.add_option("--minutes", arguments.minutes, "Of faults")
      ->check(CLI::Range(0.5, 10'000.0))
      ->capture_default_str();
  app.add_option("--seed", arguments.setup.seed, "Of all that is random")->capture_default_str();
  app.add_option("--servers", arguments.takeover.servers, "How many")
      ->check(CLI::Range(2, 16))
      ->capture_default_str();
  app.add_option("--workers", arguments.takeover.workers, "Processes that match for the servers")
      ->check(CLI::Range(0, 16))
      ->capture_default_str();
  app.add_option("--robots", arguments.setup.robots, "How many stream")
      ->check(CLI::Range(1, 4))
      ->capture_default_str();
  app.add_option("--lease", arguments.takeover.lease_s, "storage.lease_s of the servers")
      ->check(CLI::Range(1.0, 60.0))
      ->capture_default_str();
  app.add_option("--folder", arguments.setup.folder, "For maps and logs; what is there goes")
      ->required();
  CLI11_PARSE(app, argc, argv);
  try {
    return isthmus::faults::Run(arguments);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "takeover_drill: %s\n", error.what());
    return 2;
  }
}
