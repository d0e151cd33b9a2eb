// Trials of merging, in which robots' maps are joined rightly, wrongly or not at all, and the time
// that takes: worlds, seeds and overlaps through the real pipeline. lab/docs/merging.md says
// how to use it.
#include <CLI/CLI.hpp>
#include <functional>
#include <iostream>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/io/file_io.h"
#include "core/odometry_mode.h"
#include "lab/bench/merging/asked_table.h"
#include "lab/bench/merging/asked_trial.h"
#include "lab/bench/merging/calibration_table.h"
#include "lab/bench/merging/drive_cache.h"
#include "lab/bench/merging/hypothesis_table.h"
#include "lab/bench/merging/known_places.h"
#include "lab/bench/merging/odom_frames.h"
#include "lab/bench/merging/own_loops.h"
#include "lab/bench/merging/pair_cost.h"
#include "lab/bench/merging/place_index_trial.h"
#include "lab/bench/merging/recorded_parts.h"
#include "lab/bench/merging/report.h"
#include "lab/bench/merging/scenario_list.h"
#include "lab/bench/merging/update.h"
#include "lab/bench/merging/wild_pairs.h"
#include "lab/bench/merging/wild_teams.h"
#include "lab/bench/scenarios.h"

namespace isthmus::bench {
namespace {

struct Options {
  std::vector<std::string> scenarios;
  std::vector<uint64_t> seeds = {11, 12, 13, 14, 15, 16, 17, 18, 19, 20};
  double seconds = 0;
  std::string search = "default", twins = "rare", odometry = "continuous", output, cache;
  std::string kitti, poses;
  bool drive_only = false, transform = true, update = false, cost = false, calibration = false,
       teams = false, index = false, server = false, asked = false;
  TrialOptions how;
  int parts = 2;
  std::optional<double> drift_percent;
  KnownPlaces known;
  WildPairsOptions wild;
  std::string hypotheses;
};

absl::Status ReadOptions(const Options& options, server::PipelineOptions* pipeline) {
  const auto mode = ParseOdometryMode(options.odometry);
  if (!mode.ok()) return mode.status();
  pipeline->odometry.mode = *mode;
  pipeline->matcher.twins = options.twins == "possible" ? matching::Twins::kPossible
                            : options.twins == "exact"  ? matching::Twins::kExact
                                                        : matching::Twins::kRare;
  pipeline->matcher.search = options.search == "paper"       ? matching::SearchMode::kPaper
                             : options.search == "birds_eye" ? matching::SearchMode::kBirdsEye
                                                             : matching::SearchMode::kDefault;
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

// Drift, and odom frames that lie anywhere.
void SetFrames(DriftOptions drift, uint64_t seed, const Options& options,
               std::vector<DrivenRobot>* robots) {
  if (options.drift_percent) drift = {*options.drift_percent, 0.1 * *options.drift_percent};
  for (size_t i = 0; i < robots->size(); ++i) {
    DrivenRobot& robot = (*robots)[i];
    AddDrift(drift, seed + 1000 * i, &robot);
    AddAnchors(options.known, seed + 1000 * i, &robot);
    if (options.transform && i > 0) MoveOdom(RandomFrame(seed, static_cast<int>(i)), &robot);
  }
}

// The robots as the scenario wants them, from what they did; none if there is no such part.
absl::StatusOr<std::vector<DrivenRobot>> MakeRobots(const MergingScenario& scenario, uint64_t seed,
                                                    const Options& options,
                                                    const server::PipelineOptions& pipeline,
                                                    DriveCache& cache) {
  std::vector<DrivenRobot> robots;
  for (const DriveOptions& drive : DrivesOf(scenario, seed, options.seconds)) {
    auto robot = cache.Get(drive);
    if (!robot.ok()) return robot.status();
    robots.push_back(*std::move(robot));
  }
  if (scenario.overlap) {
    const bool ends_too = scenario.overlap->least == 0;
    const auto ranges = FindScanRanges(robots[0], robots[1], *scenario.overlap, ends_too);
    if (!ranges) return std::vector<DrivenRobot>();
    KeepScans(ranges->first, &robots[0]);
    KeepScans(ranges->second, &robots[1]);
    // Submaps are kept whole at their beginning, which may be too much.
    const double overlap = SeenSurface::Overlap(SeenSurface(robots[0]), SeenSurface(robots[1]));
    if (overlap > scenario.overlap->most) return std::vector<DrivenRobot>();
  }
  SetFrames(scenario.drift, seed, options, &robots);
  for (size_t i = 0; i < robots.size(); ++i) {
    if (scenario.robots[i].laps == 0) continue;
    if (absl::Status status = FindOwnLoops(pipeline, &robots[i]); !status.ok()) return status;
  }
  return robots;
}

using RobotsOf = std::function<absl::StatusOr<std::vector<DrivenRobot>>(uint64_t seed)>;

// The results of all trials.
struct Results {
  std::vector<Trial> trials;
  std::vector<UpdateTrial> updates;
  std::vector<PairCost> costs;
  std::vector<JudgedPair> judged;
};

// Submaps of each robot that come to a pair that waits.
constexpr size_t kComeLater = 6;

void MeasureCost(const std::string& name, uint64_t seed, std::vector<DrivenRobot> robots,
                 Results* results) {
  results->costs.push_back(MeasurePairCost(std::move(robots), kComeLater));
  results->costs.back().scenario = name;
  std::cerr << name << " " << seed << ": " << results->costs.back().first_s << " s" << std::endl;
}

void Judge(const std::string& name, uint64_t seed, std::vector<DrivenRobot> robots,
           Results* results) {
  JudgedPair judged = JudgeHypotheses(std::move(robots));
  judged.scenario = name;
  judged.seed = seed;
  std::cerr << judged.scenario << " " << judged.seed << std::endl;
  results->judged.push_back(std::move(judged));
}

absl::Status RunScenario(const std::string& name, const RobotsOf& robots_of,
                         const server::PipelineOptions& pipeline, const Options& options,
                         Results* results) {
  for (const uint64_t seed : options.seeds) {
    auto robots = robots_of(seed);
    if (!robots.ok()) return robots.status();
    if (robots->empty()) {
      std::cerr << name << " " << seed << ": no part of the drives is like that\n";
      continue;
    }
    if (!options.hypotheses.empty()) {
      Judge(name, seed, *std::move(robots), results);
      continue;
    }
    if (options.cost) {
      MeasureCost(name, seed, *std::move(robots), results);
      continue;
    }
    if (options.update) {
      if (robots->back().submaps.size() <= kUpdates) continue;
      auto update = RunUpdates(*std::move(robots), pipeline);
      if (!update.ok()) return update.status();
      update->scenario = name;
      results->updates.push_back(*std::move(update));
      std::cerr << name << " " << seed << std::endl;
      continue;
    }
    auto trial = RunTrial(*std::move(robots), pipeline, options.how);
    if (!trial.ok()) return trial.status();
    trial->scenario = name;
    trial->seed = seed;
    std::cerr << TrialLines(*trial) << std::endl;
    results->trials.push_back(*std::move(trial));
  }
  return absl::OkStatus();
}

absl::Status FillCache(const std::vector<MergingScenario>& scenarios, const Options& options,
                       DriveCache& cache) {
  for (const MergingScenario& scenario : scenarios) {
    for (const uint64_t seed : options.seeds) {
      for (const DriveOptions& drive : DrivesOf(scenario, seed, options.seconds)) {
        if (absl::Status status = cache.Fill(drive); !status.ok()) return status;
      }
      std::cerr << scenario.name << " " << seed << std::endl;
    }
  }
  return absl::OkStatus();
}

// Scans 0 to 59 of the recorded drive and 40 to 99, the latter also backwards.
absl::Status RunRecorded(const server::PipelineOptions& pipeline, const Options& options,
                         Results* results) {
  const auto whole = RecordedDrive(options.kitti, options.poses);
  if (!whole.ok()) return whole.status();
  DriveCache once("", pipeline);  // Quickly made, and files may change.
  for (const bool backwards : {false, true}) {
    const auto a = once.Get("first", [&]() -> absl::StatusOr<GroundedDrive> {
      return GroundedDrive{PartOf(*whole, 0, 59), "kitti", 1};
    });
    if (!a.ok()) return a.status();
    const auto b =
        once.Get(backwards ? "backwards" : "second", [&]() -> absl::StatusOr<GroundedDrive> {
          const Drive second = PartOf(*whole, 40, 99);
          if (!backwards) return GroundedDrive{second, "kitti", 1};
          auto turned = Backwards(second);
          if (!turned.ok()) return turned.status();
          return GroundedDrive{*std::move(turned), "kitti", 1};
        });
    if (!b.ok()) return b.status();
    const auto robots_of = [&](uint64_t seed) -> absl::StatusOr<std::vector<DrivenRobot>> {
      std::vector<DrivenRobot> robots = {*a, *b};
      SetFrames({}, seed, options, &robots);
      return robots;
    };
    const std::string name = backwards ? "kitti_backwards" : "kitti";
    absl::Status status = RunScenario(name, robots_of, pipeline, options, results);
    if (!status.ok()) return status;
  }
  return absl::OkStatus();
}

// Pair by pair; `--seconds` as for all drives.
absl::Status RunWild(const server::PipelineOptions& pipeline, const Options& options,
                     DriveCache& cache, Results* results) {
  WildPairsOptions wild = options.wild;
  if (options.seconds > 0) wild.seconds = options.seconds;
  const auto pairs = DrawWildPairs(wild);
  if (!pairs.ok()) return pairs.status();
  uint64_t number = 0;
  for (const WildPair& pair : *pairs) {
    const uint64_t seed = pair.seed * 1000 + number++;
    if (options.drive_only) {
      for (const DriveOptions& drive : {pair.a, pair.b}) {
        if (absl::Status status = cache.Fill(drive); !status.ok()) {
          std::cerr << drive.Key() << ": " << status << std::endl;
        }
      }
      continue;
    }
    auto robots = DriveWildPair(pair, cache);
    if (!robots.ok()) {  // Lost all the way.
      std::cerr << NameOf(pair) << " " << pair.seed << ": " << robots.status() << std::endl;
      continue;
    }
    SetFrames({}, seed, options, &*robots);
    if (!options.hypotheses.empty()) {
      Judge(NameOf(pair), pair.seed, *std::move(robots), results);
      continue;
    }
    if (options.cost) {
      MeasureCost(NameOf(pair), pair.seed, *std::move(robots), results);
      continue;
    }
    auto trial = RunTrial(*std::move(robots), pipeline, options.how);
    if (!trial.ok()) return trial.status();
    trial->scenario = NameOf(pair);
    trial->seed = pair.seed;
    trial->pairs[0].a = pair.a.robot;
    trial->pairs[0].b = pair.b.robot;
    std::cerr << TrialLines(*trial) << std::endl;
    results->trials.push_back(*std::move(trial));
  }
  return absl::OkStatus();
}

// World by world, all its robots at once.
absl::Status RunWildTeams(const server::PipelineOptions& pipeline, const Options& options,
                          DriveCache& cache, Results* results) {
  WildPairsOptions wild = options.wild;
  if (options.seconds > 0) wild.seconds = options.seconds;
  const auto teams = DrawWildTeams(wild);
  if (!teams.ok()) return teams.status();
  for (const WildTeam& team : *teams) {
    std::vector<DrivenRobot> robots = DriveWildTeam(team, cache);
    if (robots.size() < 2 || options.drive_only) continue;
    SetFrames({}, team.seed, options, &robots);
    auto trial = RunTrial(std::move(robots), pipeline, options.how);
    if (!trial.ok()) return trial.status();
    trial->scenario = team.kind;
    trial->seed = team.seed;
    std::cerr << TrialLines(*trial) << std::endl;
    results->trials.push_back(*std::move(trial));
  }
  return absl::OkStatus();
}

nlohmann::ordered_json Settings(const Options& options) {
  return {{"search", options.search},
          {"twins", options.twins},
          {"odometry", options.odometry},
          {"trials", nlohmann::ordered_json::array()}};
}

// Pair by pair, in closed loop.
absl::Status RunAsked(const server::PipelineOptions& pipeline, const Options& options,
                      DriveCache& cache) {
  WildPairsOptions wild = options.wild;
  if (options.seconds > 0) wild.seconds = options.seconds;
  const auto pairs = DrawWildPairs(wild);
  if (!pairs.ok()) return pairs.status();
  std::vector<AskedTrial> trials;
  nlohmann::ordered_json json = Settings(options);
  for (size_t i = 0; i < pairs->size(); ++i) {
    const WildPair& pair = (*pairs)[i];
    if (pair.relation != WildRelation::kTeam) continue;
    auto trial = RunAskedTrial(pair, pair.seed * 1000 + i, pipeline, cache);
    if (!trial.ok()) {
      std::cerr << NameOf(pair) << " " << pair.seed << ": " << trial.status() << std::endl;
      continue;
    }
    std::cerr << AskedLines(*trial) << std::endl;
    json["trials"].push_back(ToJson(*trial));
    trials.push_back(*std::move(trial));
  }
  std::cout << AskedTables(trials);
  if (options.output.empty()) return absl::OkStatus();
  return io::WriteFile(options.output, json.dump(2) + "\n");
}

absl::Status RunIndex(const Options& options, const server::PipelineOptions& pipeline,
                      DriveCache& cache) {
  PlaceIndexOptions index{options.wild, options.parts, options.server, pipeline};
  if (options.seconds > 0) index.wild.seconds = options.seconds;
  return options.drive_only ? DriveForPlaceIndex(index, cache)
                            : RunPlaceIndex(index, cache, std::cout);
}

absl::Status Report(const Results& results, const Options& options) {
  if (options.update) {
    std::cout << UpdateTable(results.updates);
    return absl::OkStatus();
  }
  if (options.cost) {
    std::cout << PairCostTable(results.costs);
    return absl::OkStatus();
  }
  if (!options.hypotheses.empty()) {
    std::cout << SearchTable(results.judged);
    return io::WriteFile(options.hypotheses, ToCsv(results.judged));
  }
  const std::vector<Trial>& trials = results.trials;
  if (options.teams) {
    std::cout << WildTeamsTable(trials) << "\n";
  } else if (options.wild.worlds > 0) {
    std::cout << WildTable(trials) << "\n";
  }
  std::vector<MapSharpness> maps;
  for (const Trial& t : trials) maps.push_back({t.scenario, t.seed, t.sharpness});
  std::cout << MergingTable(trials) << "\n"
            << OverlapTable(trials) << "\n"
            << TeamTable(trials) << "\n"
            << SharpnessTable(maps);
  if (options.calibration) std::cout << "\n" << ClaimTables(trials);
  if (options.output.empty()) return absl::OkStatus();
  nlohmann::ordered_json json = Settings(options);
  for (const Trial& trial : trials) json["trials"].push_back(ToJson(trial));
  return io::WriteFile(options.output, json.dump(2) + "\n");
}

absl::Status RunAll(const Options& options) {
  server::PipelineOptions pipeline;
  if (absl::Status status = ReadOptions(options, &pipeline); !status.ok()) return status;
  Results results;
  if (!options.kitti.empty()) {
    absl::Status status = RunRecorded(pipeline, options, &results);
    if (!status.ok()) return status;
  }
  // A recorded drive is measured by itself unless simulated ones are named.
  if (options.wild.worlds > 0) {
    DriveCache cache(options.cache, pipeline);
    if (options.index) return RunIndex(options, pipeline, cache);
    if (options.asked) return RunAsked(pipeline, options, cache);
    absl::Status status =
        (options.teams ? RunWildTeams : RunWild)(pipeline, options, cache, &results);
    if (!status.ok() || options.drive_only) return status;
  } else if (options.kitti.empty() || !options.scenarios.empty()) {
    const auto scenarios = FindMergingScenarios(options.scenarios);
    if (!scenarios.ok()) return scenarios.status();
    DriveCache cache(options.cache, pipeline);
    if (options.drive_only) return FillCache(*scenarios, options, cache);
    for (const MergingScenario& scenario : *scenarios) {
      const auto robots_of = [&](uint64_t seed) {
        return MakeRobots(scenario, seed, options, pipeline, cache);
      };
      absl::Status status = RunScenario(scenario.name, robots_of, pipeline, options, &results);
      if (!status.ok()) return status;
    }
  }
  return Report(results, options);
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
  app.add_option("--twins", options.twins, "rare, possible, exact: as the server's setting")
      ->check(CLI::IsMember({"rare", "possible", "exact"}))
      ->capture_default_str();
  app.add_option("--odometry", options.odometry, "continuous, floam, aloam")->capture_default_str();
  app.add_option("--cache", options.cache, "Folder that keeps drives from run to run");
  app.add_flag("--drive-only", options.drive_only, "Fill the cache, match nothing");
  app.add_flag(
      "--accept", options.how.accept_right,
      "A person accepts what was found of pairs where it is right: how good are the maps?");
  app.add_flag("--transform,!--no-transform", options.transform,
               "Move all odom frames but the first at random (default)");
  app.add_flag("--grow", options.how.grow, "Submaps come one by one and in turn, not all at once");
  app.add_option("--drift", options.drift_percent,
                 "Percent of the way, and a tenth as many degrees per metre, for every scenario");
  app.add_option("--gnss", options.known.gnss_m,
                 "Metres: robots have positions as good as that, as anchors")
      ->excludes("--grow");
  app.add_option("--start", options.known.start_m,
                 "Metres: it is known as well as that where robots began, half of it in height")
      ->excludes("--grow");
  app.add_flag("--update", options.update, "What one submap more costs, instead of the rest");
  app.add_flag("--cost", options.cost,
               "The processor time of matching a pair, instead of the rest");
  app.add_flag("--calibration", options.calibration, "Confidences against shares that are right");
  auto* wild = app.add_option("--wild", options.wild.worlds,
                              "Pairs of robots in so many wild worlds, instead of scenarios");
  app.add_option("--seed", options.wild.seed, "Of the first wild world, the others follow")
      ->needs(wild);
  app.add_option("--kind", options.wild.kind,
                 "Of the wild worlds: flat or flat,office; without: all, in turn")
      ->needs(wild);
  app.add_option("--sensor", options.wild.sensor, "In wild worlds; without: drawn")->needs(wild);
  app.add_option("--robots", options.wild.robots, "In each wild world")
      ->needs(wild)
      ->check(CLI::Range(2, 26))
      ->capture_default_str();
  app.add_option("--strangers", options.wild.strangers,
                 "SEED: only pairs of robots in two worlds of a kind, the others from this one on")
      ->needs(wild);
  app.add_flag("--whole", options.wild.whole, "Do not cut wild pairs back to an overlap drawn")
      ->needs(wild);
  app.add_flag("--one-day", options.wild.one_day,
               "Nothing is moved between the drives of a wild world's robots")
      ->needs(wild);
  app.add_option("--hypotheses", options.hypotheses,
                 "FILE.csv: what each search proposes of pairs, instead of merging them");
  app.add_flag("--teams", options.teams, "All robots of a wild world at once, not pair by pair")
      ->needs(wild);
  app.add_flag("--asked", options.asked,
               "Robots of wild pairs that wait drive as the server asks, and by themselves")
      ->needs(wild);
  auto* index = app.add_flag("--index", options.index,
                             "The place index by itself: which pairs of all sessions come first");
  index->needs(wild);
  app.add_flag("--server", options.server, "With --index: what a server with all sessions searches")
      ->needs(index);
  app.add_option("--parts", options.parts, "Sessions that each drive is cut into for --index")
      ->needs(index)
      ->check(CLI::Range(1, 100))
      ->capture_default_str();
  auto* kitti = app.add_option("--kitti", options.kitti, "Folder of a recorded drive of 100 scans");
  kitti->needs(app.add_option("--poses", options.poses, "Its true poses, rows of KITTI's kind"));
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
