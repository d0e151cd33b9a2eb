// Whether robots' maps are joined rightly, not at all or wrongly, and what that takes: worlds,
// seeds and overlaps through the real pipeline. BENCHMARK.md says how to use it.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <iostream>
#include <optional>
#include <string>
#include <vector>

#include "bench/merging/drive_cache.h"
#include "bench/merging/odom_frames.h"
#include "bench/merging/report.h"
#include "bench/merging/scenario_list.h"
#include "core/codec/file_io.h"
#include "floam/odometry_mode.h"

namespace isthmus::bench {
namespace {

struct Options {
  std::vector<std::string> scenarios;
  std::vector<uint64_t> seeds = {11, 12, 13, 14, 15, 16, 17, 18, 19, 20};
  double seconds = 0;
  std::string search = "default", odometry = "continuous", output, cache;
  bool drive_only = false, transform = true;
  std::optional<double> drift_percent;
};

absl::Status ReadOptions(const Options& options, server::PipelineOptions* pipeline) {
  const auto mode = floam::FindOdometryMode(options.odometry);
  if (!mode.ok()) return mode.status();
  pipeline->odometry.mode = *mode;
  pipeline->matcher.search = options.search;
  pipeline->composition_interval_s = 0;
  return absl::OkStatus();
}

std::vector<DriveOptions> DrivesOf(const MergingScenario& scenario, uint64_t seed, double seconds) {
  std::vector<DriveOptions> drives = scenario.robots;
  for (DriveOptions& drive : drives) {
    drive.seed += seed;
    if (seconds > 0) drive.seconds = seconds;
  }
  return drives;
}

// The robots as the scenario wants them, from what they did.
absl::StatusOr<std::vector<DrivenRobot>> MakeRobots(const MergingScenario& scenario, uint64_t seed,
                                                    const Options& options, DriveCache& cache) {
  std::vector<DrivenRobot> robots;
  for (const DriveOptions& drive : DrivesOf(scenario, seed, options.seconds)) {
    auto robot = cache.Get(drive);
    if (!robot.ok()) return robot.status();
    robots.push_back(*std::move(robot));
  }
  if (scenario.stop_at) {
    const auto stop = FindStop(robots[0], robots[1], *scenario.stop_at);
    if (stop) {
      for (DrivenRobot& robot : robots) StopAfter(*stop, &robot);
    }
  }
  DriftOptions drift = scenario.drift;
  if (options.drift_percent) drift = {*options.drift_percent, 0.1 * *options.drift_percent};
  for (size_t i = 0; i < robots.size(); ++i) {
    AddDrift(drift, seed + 1000 * i, &robots[i]);
    if (options.transform && i > 0) MoveOdom(RandomFrame(seed, static_cast<int>(i)), &robots[i]);
  }
  return robots;
}

absl::Status RunAll(const Options& options) {
  server::PipelineOptions pipeline;
  if (absl::Status status = ReadOptions(options, &pipeline); !status.ok()) return status;
  const auto scenarios = FindMergingScenarios(options.scenarios);
  if (!scenarios.ok()) return scenarios.status();
  DriveCache cache(options.cache, pipeline);
  std::vector<Trial> trials;
  for (const MergingScenario& scenario : *scenarios) {
    for (const uint64_t seed : options.seeds) {
      if (options.drive_only) {
        for (const DriveOptions& drive : DrivesOf(scenario, seed, options.seconds)) {
          if (absl::Status status = cache.Fill(drive); !status.ok()) return status;
        }
        std::cerr << scenario.name << " " << seed << std::endl;
        continue;
      }
      auto robots = MakeRobots(scenario, seed, options, cache);
      if (!robots.ok()) return robots.status();
      auto trial = RunTrial(*std::move(robots), pipeline);
      if (!trial.ok()) return trial.status();
      trial->scenario = scenario.name;
      trial->seed = seed;
      std::cerr << TrialLines(*trial) << std::endl;
      trials.push_back(*std::move(trial));
    }
  }
  if (options.drive_only) return absl::OkStatus();
  std::cout << MergingTable(trials) << "\n" << OverlapTable(trials) << "\n" << TeamTable(trials);
  if (options.output.empty()) return absl::OkStatus();
  nlohmann::ordered_json json = {{"search", options.search},
                                 {"odometry", options.odometry},
                                 {"trials", nlohmann::ordered_json::array()}};
  for (const Trial& trial : trials) json["trials"].push_back(ToJson(trial));
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
  app.add_option("--cache", options.cache, "Folder that keeps drives from run to run");
  app.add_flag("--drive-only", options.drive_only, "Fill the cache, match nothing");
  app.add_flag("--transform,!--no-transform", options.transform,
               "Move all odom frames but the first at random (default)");
  app.add_option("--drift", options.drift_percent,
                 "Percent of the way, and a tenth as many degrees per metre, for every scenario");
  app.add_option("-o,--output", options.output, "FILE.json");
  app.add_flag("--list", list, "Names of the scenarios, and nothing else");
  CLI11_PARSE(app, argc, argv);
  if (list) {
    for (const MergingScenario& scenario : MergingScenarios()) std::cout << scenario.name << "\n";
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
