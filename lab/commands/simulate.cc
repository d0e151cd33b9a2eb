// isthmus simulate: robots in a procedural world, as folders that `push` reads.

#include <optional>

#include "client/console/console.h"
#include "client/console/exit_code.h"
#include "client/console/json.h"
#include "client/console/numbers.h"
#include "client/console/offline_commands.h"
#include "client/console/say.h"
#include "lab/commands/commands.h"
#include "lab/simulation/recording.h"

namespace isthmus::cli {
namespace {

struct SimulateOptions {
  simulation::Options simulation;
  std::string output;
  bool json = false;
};

void Report(const simulation::RecordingSummary& summary, const SimulateOptions& options) {
  if (options.json) {
    Print({{"folder", options.output},
           {"robots", summary.robots},
           {"scans_per_robot", summary.scans_per_robot},
           {"overlap", summary.overlap}});
    return;
  }
  Say("%s: %d robots, %d scans each\n", options.output, summary.robots, summary.scans_per_robot);
  for (size_t i = 0; i < summary.overlap.size(); ++i) {
    for (size_t j = i + 1; j < summary.overlap[i].size(); ++j) {
      Say("robot_%d and robot_%d share %.0f %% of the smaller of their seen areas\n", i, j,
          100 * summary.overlap[i][j]);
    }
  }
}

int Run(const SimulateOptions& options) {
  std::optional<Progress> progress;
  const auto summary =
      simulation::Record(options.simulation, options.output, [&](int done, int total) {
        if (!progress) progress.emplace("scans", total);
        progress->Update(done);
      });
  progress.reset();
  if (absl::IsInvalidArgument(summary.status())) return Fail(kUsage, summary.status());
  if (!summary.ok()) return Fail(kFailed, summary.status());
  Report(*summary, options);
  return kOk;
}

}  // namespace

void AddSimulate(CLI::App& app, Action& action) {
  auto options = std::make_shared<SimulateOptions>();
  simulation::Options& simulation = options->simulation;
  CLI::App* command = AddOfflineCommand(app, "simulate");
  command
      ->add_option("--world", simulation.world,
                   "museum, warehouse, campus, corridor, twins, ...; wild-forest, ...")
      ->capture_default_str();
  command->add_option("--sensor", simulation.sensor, "vlp16, os1-64, solid, mid360, ...")
      ->capture_default_str();
  command->add_option("--robots", simulation.robots, "Robots that drive there, 1 to 100")
      ->capture_default_str();
  command->add_option("--seconds", simulation.seconds, "Length of each drive")
      ->capture_default_str();
  command->add_option("--walkers", simulation.walkers, "People among the robots, 0 to 1000")
      ->capture_default_str();
  command
      ->add_option("--cars", simulation.cars,
                   "Cars on the streets, 0 to 100; only where there are streets, as in campus")
      ->capture_default_str();
  command
      ->add_option(
          "--parked", simulation.parked,
          "Cars that park beside the streets and leave, 0 to 100; only where there are streets")
      ->capture_default_str();
  command
      ->add_option("--day", simulation.day,
                   "Day, 1 to 365: on another day the same world has other routes and noise")
      ->capture_default_str();
  command
      ->add_option("--moved", simulation.moved,
                   "Pieces of furniture that were moved, brought or taken away since day 1; only "
                   "in museum and warehouse")
      ->capture_default_str();
  command->add_option("--seed", simulation.seed, "Seed of world, drives and noise")
      ->check(NotNegative())
      ->capture_default_str();
  command->add_option("-o,--output", options->output, "Folder to write to")->required();
  command->add_flag("--json", options->json, "Summary as JSON");
  command->callback([options, &action] { action = [options] { return Run(*options); }; });
}

}  // namespace isthmus::cli
