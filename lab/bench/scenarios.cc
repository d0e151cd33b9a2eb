#include "lab/bench/scenarios.h"

#include <absl/strings/match.h>
#include <absl/strings/str_cat.h>
#include <absl/strings/str_join.h>

#include <cmath>
#include <memory>
#include <numbers>
#include <utility>

#include "lab/simulation/manoeuvre.h"
#include "lab/simulation/simulator.h"

namespace isthmus::bench {
namespace {

using simulation::Motion;
using simulation::Simulator;

constexpr double kDegree = std::numbers::pi / 180;
constexpr int kLapShots = 20'000;

// Robot 0 of two: as users get it from `isthmus simulate`.
absl::StatusOr<std::shared_ptr<const Simulator>> Tour(const std::string& world, double seconds,
                                                      const ScenarioOptions& options,
                                                      uint64_t seed) {
  simulation::Options simulated;
  simulated.world = world;
  simulated.sensor = options.sensor;
  simulated.seconds = seconds;
  simulated.seed = seed;
  auto simulator = Simulator::Create(simulated);
  if (!simulator.ok()) return simulator.status();
  return std::shared_ptr<const Simulator>(*std::move(simulator));
}

// In the same world, but moving otherwise.
std::shared_ptr<const Simulator> Moving(const Simulator& in, Motion motion, double seconds) {
  simulation::Options simulated = in.options();
  simulated.seconds = seconds;
  return std::make_shared<Simulator>(in.world(), std::vector<Motion>{std::move(motion)}, in.lidar(),
                                     simulated);
}

Drive DriveOf(std::shared_ptr<const Simulator> simulator) {
  Drive drive;
  drive.sensor = simulator->lidar().name;
  drive.shots = InOrder(simulator->scan_count(), simulator->lidar().period_s);
  drive.scan_of = [simulator](int turn) { return simulator->MakeScan(0, turn); };
  drive.truth_of = [simulator](int turn) { return simulator->Truth(0, turn).pose; };
  return drive;
}

using Make = decltype(Scenario::make);

Make Touring(const std::string& world, double seconds) {
  return [=](const ScenarioOptions& options, uint64_t seed) -> absl::StatusOr<Drive> {
    auto simulator = Tour(world, options.seconds > 0 ? options.seconds : seconds, options, seed);
    if (!simulator.ok()) return simulator.status();
    return DriveOf(*std::move(simulator));
  };
}

// From where a tour begins.
Make Standing(const std::string& world, double seconds, Motion (*motion)(const Pose&)) {
  return [=](const ScenarioOptions& options, uint64_t seed) -> absl::StatusOr<Drive> {
    const auto simulator = Tour(world, 60, options, seed);
    if (!simulator.ok()) return simulator.status();
    return DriveOf(Moving(**simulator, motion((*simulator)->PoseAt(0, 0)),
                          options.seconds > 0 ? options.seconds : seconds));
  };
}

Motion Spin(const Pose& at) { return simulation::SpinInPlace(at, 60 * kDegree, 1, 1); }

// A tour to which something happens; `trouble` returns when it is over.
Make InTrouble(const std::string& world, int (*trouble)(Drive*), double seconds = 60) {
  return [=](const ScenarioOptions& options, uint64_t seed) -> absl::StatusOr<Drive> {
    auto simulator = Tour(world, seconds, options, seed);
    if (!simulator.ok()) return simulator.status();
    Drive drive = DriveOf(*std::move(simulator));
    drive.trouble_ends = trouble(&drive);
    return drive;
  };
}

// Covers the view for two seconds of the first turn of 30 deg/s; of the sharpest if there is none.
int BlankInATurn(Drive* drive) {
  constexpr int kCount = 20;
  int sharpest = 0;
  double most = 0;
  for (int at = 100; at + 100 < static_cast<int>(drive->shots.size()); ++at) {
    const Pose before = drive->truth_of(at - 1), after = drive->truth_of(at + kCount - 1);
    const double turned = std::abs((before.Inverse() * after).Yaw());
    if (turned <= most) continue;
    most = turned;
    sharpest = at;
    if (most >= 0.1 * kCount * 30 * kDegree) break;
  }
  Cover(&drive->shots, sharpest, kCount, View::kBlank);
  return sharpest + kCount;
}

int HalfBlank(Drive* drive) {
  Cover(&drive->shots, 200, 30, View::kHalf);
  return 230;
}

int LoseScans(Drive* drive) {
  Drop(&drive->shots, 400, 30);
  Drop(&drive->shots, 300, 10);
  Drop(&drive->shots, 200, 3);
  Drop(&drive->shots, 100, 1);
  return 400 - 14;
}

int MixUpOrder(Drive* drive) {
  Swap(&drive->shots, 200);
  Duplicate(&drive->shots, 100);
  return 204;
}

int StepTheClock(Drive* drive) {
  StepClock(&drive->shots, 100, 0.05);
  StepClock(&drive->shots, 200, 0.5);
  StepClock(&drive->shots, 300, 3600);
  StepClock(&drive->shots, 400, -3600);
  return 400;
}

int CarryBack(Drive* drive) {
  PutElsewhere(&drive->shots, 300, -200);
  return 300;
}

int CarryAwayAndBack(Drive* drive) {
  PutElsewhere(&drive->shots, 300, 200);
  PutElsewhere(&drive->shots, 350, -200);
  return 350;
}

// The robot drives on all the while.
int CoverForAMinute(Drive* drive) {
  Cover(&drive->shots, 300, 600, View::kBlank);
  return 900;
}

// In one building and from one scan to the next in another: as out of a lift. Truths are in the
// frame of either building.
absl::StatusOr<Drive> Elsewhere(const ScenarioOptions& options, uint64_t seed) {
  constexpr double kThere = 30;
  constexpr uint64_t kOther = 1'000'000;  // Distance between the two seeds.
  const auto first = Tour("museum", kThere, options, seed);
  if (!first.ok()) return first.status();
  const auto then = Tour("museum", kThere, options, seed + kOther);
  if (!then.ok()) return then.status();
  const int turns = (*first)->scan_count();
  const auto in = [=](auto ask) {
    return [=](int turn) { return turn < turns ? ask(**first, turn) : ask(**then, turn - turns); };
  };
  Drive drive = DriveOf(*first);
  drive.shots = InOrder(turns + (*then)->scan_count(), (*first)->lidar().period_s);
  drive.scan_of = in([](const Simulator& sim, int turn) { return sim.MakeScan(0, turn); });
  drive.truth_of = in([](const Simulator& sim, int turn) { return sim.Truth(0, turn).pose; });
  drive.trouble_ends = turns;
  return drive;
}

// One lap is recorded, with the way there; all others are that one again, noise included.
absl::StatusOr<Drive> Laps(const ScenarioOptions& options, uint64_t seed) {
  const auto tour = Tour("campus", 60, options, seed);
  if (!tour.ok()) return tour.status();
  const double period_s = (*tour)->lidar().period_s;
  const auto lap = simulation::MakeLap((*tour)->world(), 60, period_s, seed);
  if (!lap.ok()) return lap.status();
  const int begins = static_cast<int>(std::lround(lap->begin_s / period_s));
  const int turns = static_cast<int>(std::lround(lap->seconds / period_s));
  Drive drive = DriveOf(Moving(**tour, lap->motion, lap->begin_s + lap->seconds));
  auto recording = std::make_shared<std::vector<Scan>>();
  drive.record = [recording, begins, turns, simulated = drive.scan_of] {
    for (int turn = 0; turn < begins + turns; ++turn) {
      recording->push_back(simulated(turn));
      recording->back().points.shrink_to_fit();
    }
  };
  drive.scan_of = [recording](int turn) { return (*recording)[turn]; };
  const double shots = options.seconds > 0 ? options.seconds / period_s : kLapShots;
  drive.shots = InOrder(static_cast<int>(shots), period_s);
  for (Shot& shot : drive.shots) {
    if (shot.turn >= begins) shot.turn = begins + (shot.turn - begins) % turns;
  }
  drive.lap_begins = begins;
  drive.lap_shots = turns;
  return drive;
}

}  // namespace

const std::vector<Scenario>& Scenarios() {
  using simulation::StandStill;
  static const std::vector<uint64_t> five = {1, 2, 3, 4, 5};
  static const auto* const all = new std::vector<Scenario>{
      {"museum", "a museum's rooms, 60 s at up to 1.2 m/s", five, Touring("museum", 60)},
      {"campus", "streets, 120 s at up to 4 m/s", five, Touring("campus", 120)},
      {"corridor", "lobby, 70 m of bare corridor, lobby, and back", five, Touring("corridor", 120)},
      {"blank_museum", "20 blank scans in a turn of 30 deg/s", five,
       InTrouble("museum", BlankInATurn)},
      {"blank_campus", "the same in the streets", five, InTrouble("campus", BlankInATurn)},
      {"spin_museum", "in place at 60 deg/s, six turns", five, Standing("museum", 40, Spin)},
      {"spin_campus", "the same in the streets", five, Standing("campus", 40, Spin)},
      {"still_museum", "standing still for 10 minutes", {1}, Standing("museum", 600, StandStill)},
      {"still_campus", "the same in the streets", {1}, Standing("campus", 600, StandStill)},
      {"half_museum", "30 scans see nothing ahead", five, InTrouble("museum", HalfBlank)},
      {"half_campus", "the same in the streets", five, InTrouble("campus", HalfBlank)},
      {"dropped_museum", "1, 3, 10 and 30 scans missing", five, InTrouble("museum", LoseScans)},
      {"dropped_campus", "the same in the streets", five, InTrouble("campus", LoseScans)},
      {"order", "one scan twice, two the wrong way round", five, InTrouble("museum", MixUpOrder)},
      {"clock", "steps of 0.05, 0.5, 3600 and -3600 s", five, InTrouble("museum", StepTheClock)},
      {"kidnapped_museum", "carried to where it was 20 s before", five,
       InTrouble("museum", CarryBack)},
      {"kidnapped_campus", "the same in the streets", five, InTrouble("campus", CarryBack)},
      {"away", "carried to a place not seen before, and 5 s later back", five,
       InTrouble("museum", CarryAwayAndBack)},
      {"covered", "a minute with nothing to be seen, driving on", five,
       InTrouble("museum", CoverForAMinute, 120)},
      {"elsewhere", "from one scan to the next in another building, as out of a lift", five,
       Elsewhere},
      {"laps", "one recorded lap of a campus, driven for 20,000 scans", {1}, Laps},
  };
  return *all;
}

absl::StatusOr<std::vector<Scenario>> FindScenarios(const std::vector<std::string>& names) {
  std::vector<Scenario> found;
  std::vector<bool> fits(names.size(), false);
  for (const Scenario& scenario : Scenarios()) {
    bool wanted = names.empty();
    for (size_t i = 0; i < names.size(); ++i) {
      if (!absl::StartsWith(scenario.name, names[i])) continue;
      wanted = fits[i] = true;
    }
    if (wanted) found.push_back(scenario);
  }
  for (size_t i = 0; i < names.size(); ++i) {
    if (fits[i]) continue;
    const auto name = [](std::string* out, const Scenario& s) { absl::StrAppend(out, s.name); };
    return absl::InvalidArgumentError(absl::StrCat("no scenario is called \"", names[i],
                                                   "\"; choose from ",
                                                   absl::StrJoin(Scenarios(), ", ", name)));
  }
  return found;
}

}  // namespace isthmus::bench
