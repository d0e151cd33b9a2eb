// Measures how well the points of a map are told apart: ground, walls ... See lab/docs/classes.md.
#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>

#include <CLI/CLI.hpp>
#include <fstream>
#include <iostream>
#include <iterator>
#include <random>
#include <string>
#include <vector>

#include "core/stopwatch.h"
#include "lab/bench/classes/class_table.h"
#include "lab/bench/classes/labelled_drive.h"
#include "lab/bench/cpu_clock.h"
#include "server/classes/classify.h"

namespace isthmus::bench {
namespace {

struct Options {
  DriveOptions drive;
  std::vector<std::string> worlds, sensors = {"vlp16"};
  std::vector<uint64_t> seeds = {1};
  std::string samples, forest;
  int samples_per_submap = 2000;
};

// Rows of float32: the features, the true class, the world's number.
void WriteSamples(const LabelledSubmap& submap, int count, int world, std::mt19937* rng,
                  std::ostream* out) {
  classes::Surroundings surroundings(submap.points, submap.sensors, submap.up);
  for (int i = 0; i < count; ++i) {
    const size_t point = (*rng)() % submap.points.size();
    const classes::Features features = surroundings.Of(point);
    const float labels[] = {static_cast<float>(submap.truth[point]), static_cast<float>(world)};
    out->write(reinterpret_cast<const char*>(features.data()), sizeof(features));
    out->write(reinterpret_cast<const char*>(labels), sizeof(labels));
  }
}

absl::StatusOr<classes::Forest> ForestOf(const std::string& path) {
  if (path.empty()) return classes::Forest::Own();
  std::ifstream in(path, std::ios::binary);
  return classes::Forest::Read(std::string(std::istreambuf_iterator<char>(in), {}));
}

// All drives through one world.
void Judge(const std::vector<LabelledSubmap>& submaps, const classes::Forest& forest,
           ClassCounts* counts) {
  for (const LabelledSubmap& submap : submaps) {
    const CpuClock clock(CpuClock::Of::kProcess);
    const auto labels = *classes::Classify(submap.points, submap.sensors, submap.up, forest);
    counts->cpu_ms += clock.Ms();
    for (size_t i = 0; i < labels.size(); ++i) counts->Add(submap.truth[i], labels[i]);
  }
}

absl::Status Run(Options options) {
  std::ofstream samples;
  if (!options.samples.empty()) samples.open(options.samples, std::ios::binary);
  absl::StatusOr<classes::Forest> forest = absl::UnknownError("");
  if (!samples.is_open()) forest = ForestOf(options.forest);
  if (!samples.is_open() && !forest.ok()) return forest.status();
  std::vector<ClassCounts> all;
  std::mt19937 rng(1);
  int world = 0;
  for (const uint64_t seed : options.seeds) {
    options.drive.seed = seed;
    for (const std::string& name : options.worlds) {
      options.drive.world = name;
      options.drive.sensor = options.sensors[static_cast<size_t>(world) % options.sensors.size()];
      const auto submaps = LabelledDrives(options.drive);
      if (!submaps.ok()) return submaps.status();
      std::cerr << name << " " << seed << " " << options.drive.sensor << ": " << submaps->size()
                << " submaps\n";
      ClassCounts& counts = all.emplace_back();
      counts.world = absl::StrCat(name, " ", seed, " ", options.drive.sensor);
      if (forest.ok()) Judge(*submaps, *forest, &counts);
      for (const LabelledSubmap& submap : *submaps) {
        if (samples.is_open() && !submap.points.empty()) {
          WriteSamples(submap, options.samples_per_submap, world, &rng, &samples);
        }
      }
      ++world;
    }
  }
  if (forest.ok()) std::cout << ClassTables(all);
  return absl::OkStatus();
}

int Main(int argc, char** argv) {
  CLI::App app("How well the points of a map are told apart");
  Options options;
  DriveOptions& drive = options.drive;
  app.add_option("--worlds", options.worlds, "As simulate --world, and wild-KIND")->required();
  app.add_option("--seeds", options.seeds)->capture_default_str();
  app.add_option("--seconds", drive.seconds, "Length of drives")->capture_default_str();
  app.add_option("--robots", drive.robots)->capture_default_str();
  app.add_option("--walkers", drive.walkers)->capture_default_str();
  app.add_option("--cars", drive.cars, "That drive")->capture_default_str();
  app.add_option("--parked", drive.parked, "That stand and leave")->capture_default_str();
  app.add_option("--sensors", options.sensors, "Taken in turn")->capture_default_str();
  app.add_option("--forest", options.forest, "File of another forest than the program's");
  app.add_option("--samples", options.samples, "Write samples to train with, judge nothing");
  app.add_option("--samples-per-submap", options.samples_per_submap)->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  if (absl::Status status = Run(options); !status.ok()) {
    std::cerr << status << "\n";
    return 1;
  }
  return 0;
}

}  // namespace
}  // namespace isthmus::bench

int main(int argc, char** argv) { return isthmus::bench::Main(argc, argv); }
