// The changes found after furniture was moved between two days, right ones and wrong ones.
// lab/docs/changes.md says how to use it.
#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <iostream>
#include <map>
#include <memory>
#include <numbers>
#include <set>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "lab/bench/changes/truth.h"
#include "lab/bench/cpu_clock.h"
#include "lab/bench/moving/mapped_drive.h"
#include "server/composition/changes/volumes.h"

namespace isthmus::bench {
namespace {

struct Options {
  DriveOptions drive;
  std::vector<uint64_t> seeds = {1};
  int moved = 30;
  double misplaced_m = 0.1, misplaced_deg = 0.1;
  bool list = false;
};

// Each drive lies as a whole where it was in truth, but for an error of its own.
absl::Status DriveDay(DriveOptions drive, const Options& options, TwoDays* days) {
  simulation::Random random(drive.seed, 0xC4, static_cast<uint64_t>(drive.day));
  for (drive.robot = 0; drive.robot < drive.robots; ++drive.robot) {
    auto mapped = MapDrive(drive, absl::StrCat("day", drive.day, "_robot", drive.robot));
    if (!mapped.ok()) return mapped.status();
    const double way = random.Uniform(0, 2 * std::numbers::pi), m = options.misplaced_m;
    const double turn = random.Uniform(-1, 1) * options.misplaced_deg * std::numbers::pi / 180;
    const Eigen::Vector3d off(m * std::cos(way), m * std::sin(way), 0.3 * random.Uniform(-m, m));
    for (size_t i = 0; i < mapped->submaps.size(); ++i) {
      const std::shared_ptr<const Submap>& submap = mapped->submaps[i];
      const Pose& truth = mapped->T_world_submap[i];
      // About the drive's own middle.
      const Eigen::Vector3d middle =
          mapped->T_world_submap[mapped->submaps.size() / 2].translation();
      const Pose T_about(Eigen::Quaterniond::Identity(), middle);
      const Pose error =
          T_about * Pose::FromXyzRpy(off.x(), off.y(), off.z(), 0, 0, turn) * T_about.Inverse();
      days->submaps.push_back(
          {{std::make_shared<SubmapInfo>(Summarize(*submap)), 0, error * truth}, drive.day > 1});
      days->T_world_submap.push_back(truth);
      days->content[submap->id] = submap;
    }
  }
  return absl::OkStatus();
}

absl::StatusOr<TwoDays> DriveBoth(const Options& options) {
  TwoDays days;
  DriveOptions drive = options.drive;
  if (absl::Status status = DriveDay(drive, options, &days); !status.ok()) return status;
  drive.day = 2;
  drive.moved = options.moved;
  if (absl::Status status = DriveDay(drive, options, &days); !status.ok()) return status;
  auto moved = MovedOf(drive);
  if (!moved.ok()) return moved.status();
  days.moved = *std::move(moved);
  return days;
}

absl::Status Judge(const Options& options) {
  const auto days = DriveBoth(options);
  if (!days.ok()) return days.status();
  const SubmapReader reader = [&](const SubmapId& id) { return days->content.at(id); };
  const CpuClock clock(CpuClock::Of::kProcess);
  const auto points =
      composition::FindChangedPoints(days->submaps, reader, {}, [] { return true; });
  if (!points.ok()) return points.status();
  const std::vector<ChangedVolume> volumes =
      composition::MakeVolumes(*points, days->submaps, {.wants_points = true});
  const double ms = clock.Ms();
  const Verdict verdict = Compare(*days, volumes, options.list);
  const auto came = CountDropped(*days);
  if (!came.ok()) return came.status();
  absl::PrintF("| %s | %d | %d | %d | %d | %d | %.0f | %d | %d | %.0f | %.2f | %.1f | %.2f |\n",
               options.drive.world, options.drive.seed, days->submaps.size(), days->moved.size(),
               verdict.knowable, verdict.found,
               verdict.knowable == 0 ? 100.0 : 100.0 * verdict.found / verdict.knowable,
               volumes.size(), verdict.wrong, verdict.seen_m2,
               verdict.seen_m2 > 0 ? 1000 * verdict.wrong / verdict.seen_m2 : 0,
               ms / static_cast<double>(days->submaps.size()),
               came->all == 0 ? 0 : 100.0 * came->dropped / came->all);
  return absl::OkStatus();
}

int Main(int argc, char** argv) {
  CLI::App app("How much of what was moved between two days is found, and what is found besides");
  Options options;
  DriveOptions& drive = options.drive;
  drive.seconds = 100;
  drive.walkers = 6;
  drive.truth = simulation::Truth::kMoving;
  app.add_option("--world", drive.world, "museum or warehouse")->capture_default_str();
  app.add_option("--seeds", options.seeds)->capture_default_str();
  app.add_option("--seconds", drive.seconds, "Length of drives")->capture_default_str();
  app.add_option("--robots", drive.robots, "On each day")->capture_default_str();
  app.add_option("--walkers", drive.walkers)->capture_default_str();
  app.add_option("--moved", options.moved, "Pieces")->capture_default_str();
  app.add_option("--sensor", drive.sensor)->capture_default_str();
  app.add_option("--misplaced", options.misplaced_m, "Metres by which each drive lies wrong")
      ->capture_default_str();
  app.add_option("--turned", options.misplaced_deg, "Degrees, at most, likewise")
      ->capture_default_str();
  app.add_flag("--list", options.list, "What was not found, and what is wrong");
  CLI11_PARSE(app, argc, argv);
  absl::PrintF(
      "| world | seed | submaps | came and went | knowable | found | %% | volumes | wrong | m2 | "
      "wrong per 1000 m2 | ms per submap | of what came dropped %% |\n"
      "|---|---|---|---|---|---|---|---|---|---|---|---|---|\n");
  for (const uint64_t seed : options.seeds) {
    drive.seed = seed;
    if (absl::Status status = Judge(options); !status.ok()) {
      std::cerr << status << "\n";
      return 1;
    }
    std::cout.flush();
    std::fflush(stdout);
  }
  return 0;
}

}  // namespace
}  // namespace isthmus::bench

int main(int argc, char** argv) { return isthmus::bench::Main(argc, argv); }
