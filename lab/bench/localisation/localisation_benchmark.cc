// Trials of localisation: robots that look for themselves in a map which others made, from many
// starts. lab/docs/localisation.md says how to use it.
#include <absl/strings/str_format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <iostream>
#include <string>
#include <vector>

#include "lab/bench/localisation/localisation_trial.h"
#include "lab/bench/merging/drive_cache.h"

namespace isthmus::bench {
namespace {

struct Options {
  std::vector<std::string> worlds = {"museum", "campus"};
  std::vector<uint64_t> seeds = {1, 2, 3};
  int starts = 10, robot = 1, twin = 0;
  double seconds = 0;
  std::string sensor = "vlp16", cache;
  bool stranger = false;
};

DriveOptions DriveOf(const Options& options, const std::string& world, uint64_t seed, int robot) {
  DriveOptions drive;
  drive.world = world;
  drive.seed = seed;
  drive.seconds = options.seconds > 0 ? options.seconds : world == "campus" ? 200 : 90;
  drive.laps = 2;
  drive.robot = robot;
  drive.sensor = options.sensor;
  if (world == "campus") drive.speed_mps = 2;
  return drive;
}

int Main(int argc, char** argv) {
  CLI::App app("Whether robots are found and followed in a map that others made");
  Options options;
  app.add_option("--worlds", options.worlds, "As simulate --world")->capture_default_str();
  app.add_option("--seeds", options.seeds)->capture_default_str();
  app.add_option("--starts", options.starts, "Of each drive, evenly spread")->capture_default_str();
  app.add_option("--robot", options.robot, "That is looked for: 0 drives where the map was made")
      ->capture_default_str();
  app.add_flag("--stranger", options.stranger, "Look for it in the map of the next seed");
  app.add_option("--seconds", options.seconds, "Length of drives");
  app.add_option("--sensor", options.sensor)->capture_default_str();
  app.add_option("--cache", options.cache, "Folder in which drives are kept");
  CLI11_PARSE(app, argc, argv);
  server::PipelineOptions pipeline;
  pipeline.composition_interval_s = 0;
  DriveCache cache(options.cache, pipeline);
  std::vector<LocalisationTrial> trials;
  for (const std::string& world : options.worlds) {
    for (const uint64_t seed : options.seeds) {
      const auto map = cache.Get(DriveOf(options, world, options.stranger ? seed + 1 : seed, 0));
      const auto drive = SimulateDrive(DriveOf(options, world, seed, options.robot));
      if (!map.ok() || !drive.ok()) {
        std::cerr << map.status() << drive.status() << "\n";
        return 1;
      }
      auto trial = RunLocalisation(*map, drive->drive, options.starts, !options.stranger);
      if (!trial.ok()) {
        std::cerr << trial.status() << "\n";
        return 1;
      }
      trial->name = absl::StrFormat("%s %d", world, seed);
      std::cout << ToText(*trial) << std::flush;
      trials.push_back(*std::move(trial));
    }
  }
  std::cout << Summary(trials);
  return 0;
}

}  // namespace
}  // namespace isthmus::bench

int main(int argc, char** argv) { return isthmus::bench::Main(argc, argv); }
