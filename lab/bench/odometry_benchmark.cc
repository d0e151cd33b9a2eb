// End-to-end benchmark of the odometry: cost, errors and honesty on simulated and recorded drives.
// lab/docs/odometry.md says how to use it.
#include <absl/strings/str_format.h>

#include <CLI/CLI.hpp>
#include <ctime>
#include <iostream>
#include <string>
#include <thread>
#include <vector>

#include "core/io/file_io.h"
#include "core/odometry_mode.h"
#include "lab/bench/compensated.h"
#include "lab/bench/report.h"
#include "lab/bench/run.h"
#include "lab/bench/scenarios.h"
#include "lab/bench/summary.h"
#include "lab/bench/wild/wild_benchmark.h"

namespace isthmus::bench {
namespace {

struct Options {
  std::vector<std::string> scenarios;
  std::vector<uint64_t> seeds;
  std::string mode = "continuous", kitti, poses, output;
  ScenarioOptions scenario{.sensor = ""};
  WildBenchmarkOptions wild;
  int repeats = 1;
  bool compensated = false, list = false;
};

// Each scan's cost becomes the median of those of `repeats` runs; all else is the same every time.
absl::StatusOr<RunRecord> RunRepeatedly(const Drive& drive, const floam::OdometryOptions& options,
                                        int repeats) {
  if (drive.record) drive.record();
  std::vector<RunRecord> runs;
  for (int i = 0; i < repeats; ++i) {
    auto run = Run(drive, options);
    if (!run.ok()) return run.status();
    runs.push_back(*std::move(run));
  }
  RunRecord& first = runs[0];
  for (size_t scan = 0; scan < first.scans.size(); ++scan) {
    for (double ScanRecord::*cost : {&ScanRecord::ms, &ScanRecord::features_ms,
                                     &ScanRecord::matching_ms, &ScanRecord::map_ms}) {
      std::vector<double> costs;
      for (const RunRecord& run : runs) costs.push_back(run.scans[scan].*cost);
      first.scans[scan].*cost = Percentile(costs, 0.5);
    }
  }
  for (const RunRecord& run : runs) first.cal_ms = std::min(first.cal_ms, run.cal_ms);
  return std::move(first);
}

class Benchmark {
 public:
  explicit Benchmark(const Options& options) : options_(options) {}

  absl::Status RunAll() {
    const auto mode = ParseOdometryMode(options_.mode);
    if (!mode.ok()) return mode.status();
    odometry_.mode = *mode;
    if (options_.wild.drives > 0) {
      auto entries = RunWildDrives(options_.wild, odometry_);
      if (!entries.ok()) return entries.status();
      wild_ = *std::move(entries);
      return absl::OkStatus();
    }
    if (!options_.kitti.empty()) {
      const auto drive = RecordedDrive(options_.kitti, options_.poses);
      if (!drive.ok()) return drive.status();
      return AddBoth("kitti", 0, *drive);
    }
    const auto scenarios = FindScenarios(options_.scenarios);
    if (!scenarios.ok()) return scenarios.status();
    for (const Scenario& scenario : *scenarios) {
      for (const uint64_t seed : options_.seeds.empty() ? scenario.seeds : options_.seeds) {
        const auto drive = scenario.make(options_.scenario, seed);
        if (!drive.ok()) return drive.status();
        if (auto status = AddBoth(scenario.name, seed, *drive); !status.ok()) return status;
      }
    }
    return absl::OkStatus();
  }

  absl::Status Report() const {
    if (!entries_.empty()) std::cout << ToMarkdown(entries_);
    if (!wild_.empty()) std::cout << ToMarkdown(wild_);
    if (options_.output.empty()) return absl::OkStatus();
    nlohmann::ordered_json json = {{"unix_time", std::time(nullptr)},
                                   {"compiler", __VERSION__},
                                   {"cores", std::thread::hardware_concurrency()},
                                   {"runs", nlohmann::ordered_json::array()}};
    for (const Entry& entry : entries_) json["runs"].push_back(ToJson(entry));
    for (const WildEntry& entry : wild_) json["wild"].push_back(ToJson(entry));
    return io::WriteFile(options_.output, json.dump(2) + "\n");
  }

 private:
  absl::Status Add(const std::string& name, uint64_t seed, Drive drive) {
    KeepEvery(&drive.shots, options_.wild.every);
    const auto run = RunRepeatedly(drive, odometry_, options_.repeats);
    if (!run.ok()) return run.status();
    entries_.push_back({name, options_.mode, drive.sensor, seed, drive.shots.size(),
                        Summarize(drive, *run, name == "corridor")});
    std::cerr << ToLine(entries_.back()) << std::endl;
    return absl::OkStatus();
  }

  // As it is and, where that is asked for, compensated.
  absl::Status AddBoth(const std::string& name, uint64_t seed, const Drive& drive) {
    if (auto status = Add(name, seed, drive); !status.ok()) return status;
    if (!options_.compensated) return absl::OkStatus();
    const auto compensated = Compensated(drive);
    if (!compensated.ok()) return compensated.status();
    return Add(name + "_compensated", seed, *compensated);
  }

  const Options options_;
  floam::OdometryOptions odometry_;
  std::vector<Entry> entries_;
  std::vector<WildEntry> wild_;
};

void Describe(CLI::App* app, Options* options) {
  auto* scenario =
      app->add_option("--scenario", options->scenarios,
                      "Names, or what names begin with; without it all that are simulated");
  app->add_option("--seeds", options->seeds,
                  "Of worlds, drives and noise; without it each "
                  "scenario's own");
  app->add_option("--mode", options->mode, "continuous, floam, aloam")->capture_default_str();
  app->add_option(
      "--sensor", options->scenario.sensor,
      "Simulated: vlp16, os1-64, solid, mid360, ...; without it vlp16, of wild drives any");
  app->add_option("--seconds", options->scenario.seconds,
                  "Length of drives to which nothing happens at a set time; 0: as meant")
      ->check(CLI::Range(0.0, 1e6));
  app->add_option("--every", options->wild.every, "Only every so many'th scan: key scans")
      ->check(CLI::Range(1, 1'000'000));
  app->add_option("--repeats", options->repeats, "Runs of each drive, of which costs are medians")
      ->check(CLI::Range(1, 1'000'000))
      ->capture_default_str();
  auto* kitti = app->add_option("--kitti", options->kitti,
                                "Folder of a recorded drive's .bin scans, instead of scenarios");
  app->add_option("--poses", options->poses, "Its reference poses: KITTI rows of the LiDAR")
      ->needs(kitti);
  auto* wild = app->add_option("--wild", options->wild.drives,
                               "So many drives in wild worlds, other ones every time, instead")
                   ->check(CLI::Range(1, 1'000'000))
                   ->excludes(kitti)
                   ->excludes(scenario);
  app->add_option("--seed", options->wild.seed, "Of the first of them, to have it again")
      ->needs(wild);
  app->add_option("--kind", options->wild.drawn.kind, "Of world; without it any")->needs(wild);
  app->add_option("--cache", options->wild.cache, "Folder to keep these drives in")->needs(wild);
  app->add_option("--jobs", options->wild.jobs, "So many at a time; costs are honest with 1")
      ->check(CLI::Range(1, 1024))
      ->needs(wild);
  app->add_option("-o,--output", options->output, "FILE.json");
  app->add_flag("--compensated", options->compensated,
                "Every drive once more, its scans compensated for motion by the truth")
      ->excludes(wild);
  app->add_flag("--list", options->list, "Names of the scenarios, and nothing else");
}

int Main(int argc, char** argv) {
  CLI::App app("Cost, errors and honesty of the odometry, scenario by scenario");
  Options options;
  Describe(&app, &options);
  CLI11_PARSE(app, argc, argv);
  options.wild.drawn.sensor = options.scenario.sensor;
  if (options.scenario.sensor.empty()) options.scenario.sensor = "vlp16";
  if (options.scenario.seconds > 0) options.wild.drawn.seconds = options.scenario.seconds;
  if (options.list) {
    for (const Scenario& s : Scenarios()) absl::PrintF("%-15s %s\n", s.name, s.what);
    return 0;
  }
  Benchmark benchmark(options);
  absl::Status status = benchmark.RunAll();
  if (status.ok()) status = benchmark.Report();
  if (status.ok()) return 0;
  std::cerr << "odometry_benchmark: " << status.message() << std::endl;
  return 1;
}

}  // namespace
}  // namespace isthmus::bench

int main(int argc, char** argv) { return isthmus::bench::Main(argc, argv); }
