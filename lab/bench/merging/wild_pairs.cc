#include "lab/bench/merging/wild_pairs.h"

#include <absl/strings/match.h>
#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>
#include <absl/strings/str_split.h>

#include <algorithm>
#include <array>
#include <map>
#include <utility>

#include "lab/bench/merging/figures.h"
#include "lab/simulation/random.h"
#include "lab/simulation/wild/wild.h"

namespace isthmus::bench {
namespace {

using simulation::Random;
using simulation::WildTwin;

// Half of all robots have the first.
constexpr const char* kSensors[] = {"vlp16", "vlp16", "vlp16",  "vlp16",  "vlp16",
                                    "vlp32", "hdl32", "os0-32", "os1-32", "os1-64"};
// Buildings that are built twice, besides what is furnished.
constexpr const char* kTwinKinds[] = {"hotel", "house", "warehouse"};

template <typename Names>
bool Contains(const Names& names, const std::string& name) {
  return std::find(std::begin(names), std::end(names), name) != std::end(names);
}

DriveOptions Robot(const WildPairsOptions& options, const std::string& kind, uint64_t seed,
                   int robot) {
  Random random(seed, 0xA1, static_cast<uint64_t>(robot));
  DriveOptions drive;
  drive.world = absl::StrCat(simulation::kWildPrefix, kind);
  drive.seed = seed;
  drive.seconds = options.seconds;
  drive.robots = options.robots;
  drive.robot = robot;
  drive.first_day = options.one_day;
  drive.sensor = options.sensor.empty()
                     ? kSensors[random.Index(static_cast<int>(std::size(kSensors)))]
                     : options.sensor;
  return drive;
}

std::string KindOf(const WildPairsOptions& options, uint64_t seed) {
  const std::vector<std::string> kinds =
      options.kind.empty() ? simulation::WildKinds() : absl::StrSplit(options.kind, ',');
  return kinds[seed % kinds.size()];
}

std::vector<WildPair> DrawStrangers(const WildPairsOptions& options, uint64_t first_seed) {
  std::vector<WildPair> pairs;
  for (int world = 0; world < options.worlds; ++world) {
    const uint64_t seed = options.seed + static_cast<uint64_t>(world);
    const std::string kind = KindOf(options, seed);
    const bool one_kind = KindOf(options, seed) == options.kind;
    uint64_t other = one_kind ? first_seed + seed - options.seed : first_seed;
    while (KindOf(options, other) != kind) ++other;
    for (int a = 0; a < options.robots; ++a) {
      for (int b = 0; b < options.robots; ++b) {
        pairs.push_back({WildRelation::kStranger, kind, seed, Robot(options, kind, seed, a),
                         Robot(options, kind, other, b)});
      }
    }
  }
  return pairs;
}

// A row of a table: how many there are of what became of them.
struct Tally {
  std::array<int, 3> outcomes = {};  // By TrialOutcome.
  int hypotheses_right = 0;
  std::vector<double> right_m;

  void Add(const PairResult& pair) {
    ++outcomes[static_cast<size_t>(pair.outcome)];
    hypotheses_right += pair.hypothesis_right && pair.HasHypothesis();
    if (pair.outcome == TrialOutcome::kRight) right_m.push_back(pair.map.median_m);
  }
  int count() const { return outcomes[0] + outcomes[1] + outcomes[2]; }
};

std::string Row(const std::string& name, const Tally& tally) {
  return absl::StrFormat("| %s | %d | %d | %.0f %% | %d | %d | %d | %.3f (%.3f) |\n", name,
                         tally.count(), tally.outcomes[0],
                         100.0 * tally.outcomes[0] / std::max(1, tally.count()),
                         tally.hypotheses_right, tally.outcomes[1], tally.outcomes[2],
                         Median(tally.right_m), Worst(tally.right_m));
}

// The class of a pair by what both have in common, in words that sort.
std::string ClassOf(const Trial& trial, const PairResult& pair) {
  if (absl::EndsWith(trial.scenario, " exact twin")) return "twins, exact";
  if (absl::EndsWith(trial.scenario, " bare twin")) return "twins, bare";
  if (absl::EndsWith(trial.scenario, " twin")) return "twins";
  if (absl::EndsWith(trial.scenario, " stranger")) return "strangers";
  if (pair.overlap >= 0.3) return "overlap 0.30 and more";
  if (pair.overlap >= 0.15) return "overlap 0.15-0.30";
  return pair.overlap >= 0.02 ? "overlap 0.02-0.15" : "no overlap";
}

}  // namespace

std::string NameOf(const WildPair& pair) {
  switch (pair.relation) {
    case WildRelation::kTeam:
      break;
    case WildRelation::kStranger:
      return absl::StrCat(pair.kind, " stranger");
    case WildRelation::kTwin:
      return absl::StrCat(pair.kind, " twin");
    case WildRelation::kExactTwin:
      return absl::StrCat(pair.kind, " exact twin");
    case WildRelation::kBareTwin:
      return absl::StrCat(pair.kind, " bare twin");
  }
  return pair.kind;
}

absl::StatusOr<std::vector<WildPair>> DrawWildPairs(const WildPairsOptions& options) {
  if (options.strangers) return DrawStrangers(options, *options.strangers);
  std::vector<WildPair> pairs;
  std::map<std::string, DriveOptions> before;  // By kind, of the last world.
  for (int world = 0; world < options.worlds; ++world) {
    const uint64_t seed = options.seed + static_cast<uint64_t>(world);
    const std::string kind = KindOf(options, seed);
    const auto known = simulation::ChooseWild(seed, {kind, "vlp16", options.seconds});
    if (!known.ok()) return known.status();
    Random random(seed, 0xA2, 0);
    const auto robot = [&](int i) { return Robot(options, kind, seed, i); };
    const auto add = [&](WildRelation relation, const DriveOptions& a, const DriveOptions& b) {
      const double most_overlap = random.Uniform(0.15, 0.95);
      pairs.push_back({relation, kind, seed, a, b, options.whole ? 1 : most_overlap});
    };
    for (int a = 0; a < options.robots; ++a) {
      for (int b = a + 1; b < options.robots; ++b) add(WildRelation::kTeam, robot(a), robot(b));
    }
    const auto stranger = before.find(kind);
    if (stranger != before.end()) add(WildRelation::kStranger, robot(0), stranger->second);
    before[kind] = robot(1);
    const bool furnished = Contains(simulation::FurnishedKinds(), kind);
    if (furnished || Contains(kTwinKinds, kind)) {
      DriveOptions twin = robot(1);
      twin.twin = WildTwin::kRefurnished;
      add(WildRelation::kTwin, robot(0), twin);
    }
    for (const bool bare : {false, true}) {
      if (!furnished) break;
      DriveOptions here = robot(0), there = robot(1);
      here.bare = there.bare = bare;
      here.first_day = there.first_day = true;
      there.twin = WildTwin::kExact;
      add(bare ? WildRelation::kBareTwin : WildRelation::kExactTwin, here, there);
    }
  }
  return pairs;
}

absl::StatusOr<std::vector<DrivenRobot>> WholeRobots(const WildPair& pair, DriveCache& cache) {
  std::vector<DrivenRobot> robots;
  for (const DriveOptions& drive : {pair.a, pair.b}) {
    auto robot = cache.Get(drive);
    if (!robot.ok()) return robot.status();
    robots.push_back(*std::move(robot));
  }
  return robots;
}

std::pair<ScanRange, ScanRange> KeptScans(const WildPair& pair,
                                          const std::vector<DrivenRobot>& whole) {
  if (pair.relation != WildRelation::kTeam) return {};
  const OverlapRange wanted{std::max(0.1, pair.most_overlap - 0.1), pair.most_overlap};
  const double overlap = SeenSurface::Overlap(SeenSurface(whole[0]), SeenSurface(whole[1]));
  if (overlap <= pair.most_overlap) return {};
  return FindScanRanges(whole[0], whole[1], wanted, true)
      .value_or(std::pair<ScanRange, ScanRange>());
}

absl::StatusOr<std::vector<DrivenRobot>> DriveWildPair(const WildPair& pair, DriveCache& cache) {
  auto robots = WholeRobots(pair, cache);
  if (!robots.ok()) return robots.status();
  const auto [of_a, of_b] = KeptScans(pair, *robots);
  KeepScans(of_a, &(*robots)[0]);
  KeepScans(of_b, &(*robots)[1]);
  return robots;
}

std::string WildTable(const std::vector<Trial>& trials) {
  std::map<std::string, Tally> classes;
  std::map<std::string, Tally> kinds;  // Pairs that overlap by 0.3 and more.
  for (const Trial& trial : trials) {
    for (const PairResult& pair : trial.pairs) {
      const std::string name = ClassOf(trial, pair);
      classes[name].Add(pair);
      if (absl::StartsWith(name, "overlap 0.30")) kinds[trial.scenario].Add(pair);
    }
  }
  std::string table =
      "| pairs | count | right | | best hypothesis right | not merged | WRONG | map on map m "
      "(worst) |\n|---|---|---|---|---|---|---|---|\n";
  for (const auto& [name, tally] : classes) table += Row(name, tally);
  for (const auto& [name, tally] : kinds)
    table += Row(absl::StrCat("0.30 and more: ", name), tally);
  return table;
}

}  // namespace isthmus::bench
