// Whether two robots' maps are joined rightly, not at all or wrongly, and what that takes: worlds,
// seeds and overlaps through the real pipeline. BENCHMARK.md says how to use it.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <iostream>
#include <string>
#include <vector>

#include "bench/merging/report.h"
#include "core/codec/file_io.h"
#include "floam/odometry_mode.h"

namespace isthmus::bench {
namespace {

struct Scenario {
  std::string name;
  PairOptions pair;
};

// Overlaps follow from how long robots drive; the table tells them.
std::vector<Scenario> Scenarios() {
  return {
      {"museum", {.world_a = "museum"}},
      {"museum_short", {.world_a = "museum", .seconds = 30}},
      {"museum_walkers", {.world_a = "museum", .walkers = 12}},
      {"museum_tilted", {.world_a = "museum", .tilt_deg = 5}},
      {"campus", {.world_a = "campus", .seconds = 120}},
      {"campus_short", {.world_a = "campus", .seconds = 60}},
      {"campus_walkers", {.world_a = "campus", .seconds = 120, .walkers = 30}},
      {"twins", {.world_a = "twins", .seconds = 40}},
      {"twins_joined", {.world_a = "twins_joined", .seconds = 80}},
      {"museum_or_campus", {.world_a = "museum", .world_b = "campus"}},
      {"museum_or_twins", {.world_a = "museum", .world_b = "twins", .seconds = 40}},
      {"museum_or_corridor", {.world_a = "museum", .world_b = "corridor"}},
  };
}

struct Options {
  std::vector<std::string> scenarios;
  std::vector<uint64_t> seeds = {11, 12, 13, 14, 15, 16, 17, 18, 19, 20};
  double seconds = 0;
  std::string search = "default", odometry = "continuous", output;
};

absl::Status ReadOptions(const Options& options, server::PipelineOptions* pipeline) {
  const auto mode = floam::FindOdometryMode(options.odometry);
  if (!mode.ok()) return mode.status();
  pipeline->odometry.mode = *mode;
  pipeline->matcher.search = options.search;
  // Only the whole maps are judged: what was tried on the way is not waited for.
  pipeline->rematch_submaps = 1000;
  return absl::OkStatus();
}

absl::Status RunAll(const Options& options) {
  server::PipelineOptions pipeline;
  if (absl::Status status = ReadOptions(options, &pipeline); !status.ok()) return status;
  std::vector<ScenarioTrials> all;
  for (Scenario scenario : Scenarios()) {
    const auto& wanted = options.scenarios;
    if (!wanted.empty() && std::find(wanted.begin(), wanted.end(), scenario.name) == wanted.end()) {
      continue;
    }
    if (options.seconds > 0) scenario.pair.seconds = options.seconds;
    ScenarioTrials& done = all.emplace_back(ScenarioTrials{scenario.name, {}});
    for (const uint64_t seed : options.seeds) {
      scenario.pair.seed = seed;
      const auto pair = Pair::Make(scenario.pair);
      if (!pair.ok()) return pair.status();
      const auto trial = RunTrial(*pair, seed, pipeline);
      if (!trial.ok()) return trial.status();
      done.trials.push_back(*trial);
      std::cerr << TrialLine(scenario.name, *trial) << std::endl;
    }
  }
  if (all.empty()) return absl::InvalidArgumentError("no scenario has such a name (see --list)");
  std::cout << MergingTable(all);
  if (options.output.empty()) return absl::OkStatus();
  nlohmann::ordered_json json = {{"search", options.search},
                                 {"odometry", options.odometry},
                                 {"scenarios", nlohmann::ordered_json::array()}};
  for (const ScenarioTrials& scenario : all) json["scenarios"].push_back(ToJson(scenario));
  return codec::WriteFile(options.output, json.dump(2) + "\n");
}

int Main(int argc, char** argv) {
  CLI::App app("Whether robots' maps are joined rightly, not at all or wrongly");
  Options options;
  bool list = false;
  app.add_option("--scenario", options.scenarios, "Names; without it all");
  app.add_option("--seeds", options.seeds, "Of worlds, drives and noise")->capture_default_str();
  app.add_option("--seconds", options.seconds, "Length of drives; 0: each scenario's own");
  app.add_option("--search", options.search, "default, paper, birds_eye")
      ->check(CLI::IsMember({"default", "paper", "birds_eye"}))
      ->capture_default_str();
  app.add_option("--odometry", options.odometry, "continuous, floam, aloam")->capture_default_str();
  app.add_option("-o,--output", options.output, "FILE.json");
  app.add_flag("--list", list, "Names of the scenarios, and nothing else");
  CLI11_PARSE(app, argc, argv);
  if (list) {
    for (const Scenario& scenario : Scenarios()) std::cout << scenario.name << "\n";
    return 0;
  }
  const absl::Status status = RunAll(options);
  if (status.ok()) return 0;
  std::cerr << "merging_benchmark: " << status.message() << std::endl;
  return 1;
}

}  // namespace
}  // namespace isthmus::bench

int main(int argc, char** argv) { return isthmus::bench::Main(argc, argv); }
