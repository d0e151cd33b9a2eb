// Trials of mapping, whether loops make maps right, maps stop growing, and changes can be undone:
// recorded drives with bad odometry through the real server. lab/docs/mapping.md says how to
// use it.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <functional>
#include <iostream>
#include <string>
#include <utility>
#include <vector>

#include "core/io/file_io.h"
#include "lab/bench/mapping/report.h"
#include "lab/bench/merging/drive_cache.h"
#include "lab/bench/merging/odom_frames.h"

namespace isthmus::bench {
namespace {

struct Options {
  std::vector<std::string> studies;
  std::vector<uint64_t> seeds = {1, 2, 3};
  std::string cache, output, picture;
  double drift_percent = 1, drift_deg_per_m = 0.05;  // For the campus drives.
  double false_share = 0.3;
  int laps = 1000, every = 100;
  size_t points = 0;

  DriftOptions drift() const { return {drift_percent, drift_deg_per_m}; }
};

// Everything that a study needs.
struct Bench {
  const Options& options;
  server::PipelineOptions pipeline;
  DriveCache cache;
  MappingResults results;
};

DriveOptions AroundCampus(uint64_t seed) {
  return {.world = "campus", .seed = seed, .seconds = 60, .laps = 3, .speed_mps = 2, .robots = 1};
}

// Robot 0 of two drives around twice, robot 1 does not come back.
DriveOptions OneOfTwo(uint64_t seed, int robot) {
  return {.world = "campus",
          .seed = seed,
          .seconds = 200,
          .laps = robot == 0 ? 2 : 0,
          .speed_mps = 2,
          .robot = robot};
}

DriveOptions AroundMuseum(uint64_t seed) {
  return {.world = "museum", .seed = seed, .seconds = 60, .laps = 3, .robots = 1};
}

absl::StatusOr<std::vector<DrivenRobot>> GetAll(const std::vector<DriveOptions>& drives,
                                                Bench& bench) {
  std::vector<DrivenRobot> robots;
  for (const DriveOptions& drive : drives) {
    auto robot = bench.cache.Get(drive);
    if (!robot.ok()) return robot.status();
    robots.push_back(*std::move(robot));
  }
  return robots;
}

absl::Status RunMap(const std::string& name, uint64_t seed, const std::vector<DrivenRobot>& robots,
                    const std::string& picture, Bench& bench) {
  auto trial = RunMapTrial(robots, {bench.pipeline, picture});
  if (!trial.ok()) return trial.status();
  trial->name = name;
  trial->seed = seed;
  MappingResults this_one;
  this_one.maps = {*trial};
  std::cerr << MappingTables(this_one) << std::flush;
  bench.results.maps.push_back(*std::move(trial));
  return absl::OkStatus();
}

absl::StatusOr<DrivenRobot> AroundCampusWithDrift(uint64_t seed, Bench& bench) {
  auto robot = bench.cache.Get(AroundCampus(seed));
  if (robot.ok()) AddDrift(bench.options.drift(), seed, &*robot);
  return robot;
}

absl::Status Loops(uint64_t seed, Bench& bench) {
  const auto robot = AroundCampusWithDrift(seed, bench);
  if (!robot.ok()) return robot.status();
  const bool draw = seed == bench.options.seeds.front();
  return RunMap("loops", seed, {*robot}, draw ? bench.options.picture : "", bench);
}

// As driven; with drift of the robot that comes back; with drift of both.
absl::Status TwoRobots(uint64_t seed, Bench& bench) {
  const auto driven = GetAll({OneOfTwo(seed, 0), OneOfTwo(seed, 1)}, bench);
  if (!driven.ok()) return driven.status();
  const std::string names[] = {"two as driven", "two, drift of a", "two, drift of both"};
  for (size_t drifting = 0; drifting <= 2; ++drifting) {
    std::vector<DrivenRobot> robots = *driven;
    for (size_t i = 0; i < drifting; ++i) AddDrift(bench.options.drift(), seed + i, &robots[i]);
    MoveOdom(RandomFrame(seed, 1), &robots[1]);
    absl::Status status = RunMap(names[drifting], seed, robots, "", bench);
    if (!status.ok()) return status;
  }
  return absl::OkStatus();
}

// One robot drives the first two thirds of a lap and another the rest and on into the first part, a
// lap later: they meet twice, and neither comes back to where it was. With drift of both.
absl::Status TwoMeetings(uint64_t seed, Bench& bench) {
  const auto laps = bench.cache.Get(AroundCampus(seed));
  if (!laps.ok()) return laps.status();
  const double lap = static_cast<double>(laps->submaps.size()) / AroundCampus(seed).laps;
  const auto part = [&](double from, double to) {
    return PartOf(*laps, static_cast<size_t>(from * lap), static_cast<size_t>(to * lap));
  };
  std::vector<DrivenRobot> robots = {part(0, 0.65), part(1.45, 2.2)};
  for (size_t i = 0; i < robots.size(); ++i) AddDrift(bench.options.drift(), seed + i, &robots[i]);
  MoveOdom(RandomFrame(seed, 1), &robots[1]);
  return RunMap("two meetings", seed, robots, "", bench);
}

// On the closures of the study `loops`, which is run if it has not been.
absl::Status FalseLoops(uint64_t seed, Bench& bench) {
  const auto found = [&]() -> const MapTrial* {
    for (const MapTrial& trial : bench.results.maps) {
      if (trial.name == "loops" && trial.seed == seed) return &trial;
    }
    return nullptr;
  };
  if (found() == nullptr) {
    if (absl::Status status = Loops(seed, bench); !status.ok()) return status;
  }
  std::vector<LoopClosure> loops;
  for (const Loop& status : found()->found) loops.push_back(status.loop);
  auto robot = AroundCampusWithDrift(seed, bench);
  if (!robot.ok()) return robot.status();
  if (!loops.empty()) robot->session.id = loops.front().session;
  for (const FalseKind kind : {FalseKind::kRandom, FalseKind::kNear, FalseKind::kTwins}) {
    bench.results.false_loops.push_back(
        RunFalseLoops(*robot, loops, kind, bench.options.false_share, seed, bench.pipeline.placer));
  }
  return absl::OkStatus();
}

// The first seed only.
absl::Status Laps(uint64_t seed, Bench& bench) {
  if (seed != bench.options.seeds.front()) return absl::OkStatus();
  const auto robot = bench.cache.Get(AroundMuseum(seed));
  if (!robot.ok()) return robot.status();
  auto replay = LapReplay::Create(*robot, {.max_points = bench.options.points, .seed = seed});
  if (!replay.ok()) return replay.status();
  std::cerr << LapsHeader();
  auto trial = RunLaps(*std::move(replay), bench.options.laps, bench.options.every, bench.pipeline,
                       [](const LapsRow& row) { std::cerr << ToLine(row) << std::flush; });
  if (!trial.ok()) return trial.status();
  bench.results.laps = *std::move(trial);
  return absl::OkStatus();
}

absl::Status Undo(uint64_t seed, Bench& bench) {
  const auto together = GetAll({OneOfTwo(seed, 0), OneOfTwo(seed, 1)}, bench);
  if (!together.ok()) return together.status();
  const auto apart = GetAll({OneOfTwo(seed, 0), AroundMuseum(seed)}, bench);
  if (!apart.ok()) return apart.status();
  for (const UndoBy how : {UndoBy::kUndoRevision, UndoBy::kWithdrawing}) {
    const bool undo = how == UndoBy::kUndoRevision;
    std::vector<DrivenRobot> robots = undo ? *apart : *together;
    AddDrift(bench.options.drift(), seed, &robots[0]);
    auto trial = RunUndo(std::move(robots), how, bench.pipeline);
    if (!trial.ok()) return trial.status();
    trial->name = undo ? "undoing the revision" : "withdrawing";
    trial->seed = seed;
    bench.results.undo.push_back(*std::move(trial));
  }
  return absl::OkStatus();
}

absl::Status NextDay(uint64_t seed, Bench& bench) {
  auto robots = GetAll({OneOfTwo(seed, 0), OneOfTwo(seed, 1)}, bench);
  if (!robots.ok()) return robots.status();
  AddDrift(bench.options.drift(), seed, &(*robots)[0]);
  MoveOdom(RandomFrame(seed, 1), &(*robots)[1]);
  auto trial = RunNextDay((*robots)[0], (*robots)[1], bench.pipeline);
  if (!trial.ok()) return trial.status();
  trial->seed = seed;
  bench.results.next_days.push_back(*std::move(trial));
  return absl::OkStatus();
}

struct Study {
  std::string name;
  absl::Status (*run)(uint64_t seed, Bench& bench);
};

const std::vector<Study>& Studies() {
  static const auto* const studies = new std::vector<Study>{
      {"loops", Loops},
      {"two_robots", TwoRobots},
      {"two_meetings", TwoMeetings},
      {"false_loops", FalseLoops},
      {"laps", Laps},
      {"undo", Undo},
      {"next_day", NextDay},
  };
  return *studies;
}

absl::Status RunAll(const Options& options) {
  server::PipelineOptions pipeline;
  pipeline.composition_interval_s = 0;  // Nobody waits for it.
  Bench bench{options, pipeline, DriveCache(options.cache, pipeline), {}};
  for (const Study& study : Studies()) {
    const bool wanted = options.studies.empty() ||
                        std::count(options.studies.begin(), options.studies.end(), study.name) > 0;
    for (size_t i = 0; wanted && i < options.seeds.size(); ++i) {
      std::cerr << study.name << " " << options.seeds[i] << std::endl;
      absl::Status status = study.run(options.seeds[i], bench);
      if (!status.ok()) return status;
    }
  }
  std::cout << MappingTables(bench.results);
  if (options.output.empty()) return absl::OkStatus();
  return io::WriteFile(options.output, ToJson(bench.results).dump(2) + "\n");
}

int Main(int argc, char** argv) {
  CLI::App app("Whether loops make maps right, and whether maps stop growing");
  Options options;
  std::vector<std::string> names;
  for (const Study& study : Studies()) names.push_back(study.name);
  app.add_option("studies", options.studies, "Names; without any all")->check(CLI::IsMember(names));
  app.add_option("--seeds", options.seeds, "Of worlds, drives, noise and drift")
      ->capture_default_str();
  app.add_option("--cache", options.cache, "Folder that keeps drives from run to run");
  app.add_option("--drift", options.drift_percent, "Percent of the way, campus")
      ->check(CLI::Range(0., 100.))
      ->capture_default_str();
  app.add_option("--drift-yaw", options.drift_deg_per_m, "Degrees per metre, campus")
      ->check(CLI::Range(0., 10.))
      ->capture_default_str();
  app.add_option("--false-share", options.false_share, "Of false_loops' edges")
      ->check(CLI::Range(0., 0.9))
      ->capture_default_str();
  app.add_option("--laps", options.laps, "Of laps")->check(CLI::Range(1, 100000));
  app.add_option("--every", options.every, "Laps between rows")->check(CLI::Range(1, 100000));
  app.add_option("--points", options.points, "Of a submap of laps, at most; 0: all");
  app.add_option("--picture", options.picture,
                 "Draw the first map of loops: PATH_open.png and PATH_closed.png");
  app.add_option("-o,--output", options.output, "FILE.json");
  CLI11_PARSE(app, argc, argv);
  const absl::Status status = RunAll(options);
  if (status.ok()) return 0;
  std::cerr << "mapping_benchmark: " << status.message() << std::endl;
  return 1;
}

}  // namespace
}  // namespace isthmus::bench

int main(int argc, char** argv) { return isthmus::bench::Main(argc, argv); }
