// The fate of people, cars and still things in the merged map. lab/docs/moving.md says how
// to use it.
#include <absl/strings/str_format.h>

#include <CLI/CLI.hpp>
#include <iostream>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "lab/bench/cpu_clock.h"
#include "lab/bench/moving/mapped_drive.h"
#include "server/composition/composer.h"

namespace isthmus::bench {
namespace {

struct Options {
  DriveOptions drive;
  std::vector<uint64_t> seeds = {1};
};

struct Counts {
  int64_t moving = 0, still = 0;
};

Counts Count(const ComposedMap& map) {
  Counts counts;
  const absl::Status status = map.Read({}, 10000, [&](const std::vector<MapPoint>& points) {
    for (const MapPoint& point : points) {
      ++(point.intensity > kMovingIntensity ? counts.moving : counts.still);
    }
    return true;
  });
  if (!status.ok()) std::cerr << status << "\n";
  return counts;
}

struct Composed {
  std::shared_ptr<const ComposedMap> map;
  double ms = 0, mb = 0;  // All submaps read, thinned and composed; what the composer keeps.
};

absl::StatusOr<Composed> Compose(const MappedTeam& team, bool drop_gone) {
  composition::Composer composer({.cache_bytes = size_t{4} << 30, .drop_gone = drop_gone});
  const CpuClock clock(CpuClock::Of::kProcess);
  auto map = composer.Compose(1, team.placed, team.reader());
  if (!map.ok()) return map.status();
  const composition::Composer::Memory memory = composer.memory();
  return Composed{*std::move(map), clock.Ms(),
                  1e-6 * static_cast<double>(memory.submap_bytes + memory.tile_bytes)};
}

double Percent(int64_t part, int64_t rest) {
  return part + rest == 0 ? 0 : 100 * static_cast<double>(part) / static_cast<double>(part + rest);
}

absl::Status Judge(const DriveOptions& drive) {
  const auto team = MapTeam(drive);
  if (!team.ok()) return team.status();
  const auto all = Compose(*team, false), map = Compose(*team, true);
  if (!all.ok()) return all.status();
  if (!map.ok()) return map.status();
  const Counts before = Count(*all->map), kept = Count(*map->map),
               dropped = Count(*map->map->dropped());
  absl::PrintF("| %s | %d | %d | %d | %.2f | %.2f | %.3f | %.1f | %.1f | %.1f | %.1f |\n",
               drive.world, drive.seed, team->placed.size(), before.moving + before.still,
               Percent(before.moving, before.still), Percent(dropped.moving, kept.moving),
               Percent(dropped.still, kept.still),
               all->ms / static_cast<double>(team->placed.size()), map->ms / all->ms, all->mb,
               map->mb / all->mb);
  return absl::OkStatus();
}

int Main(int argc, char** argv) {
  CLI::App app("How much of who moves is left in the merged map, and what still things lose");
  Options options;
  DriveOptions& drive = options.drive;
  drive.seconds = 120;
  drive.walkers = 12;
  drive.truth = simulation::Truth::kMoving;
  app.add_option("--world", drive.world, "As simulate --world")->capture_default_str();
  app.add_option("--seeds", options.seeds)->capture_default_str();
  app.add_option("--seconds", drive.seconds, "Length of drives")->capture_default_str();
  app.add_option("--robots", drive.robots)->capture_default_str();
  app.add_option("--walkers", drive.walkers)->capture_default_str();
  app.add_option("--cars", drive.cars, "That drive")->capture_default_str();
  app.add_option("--parked", drive.parked, "That stand and leave")->capture_default_str();
  app.add_option("--sensor", drive.sensor)->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  absl::PrintF(
      "| world | seed | submaps | points | moving %% | of these gone %% | of still ones gone %% | "
      "ms "
      "per submap | times | MB | times |\n|---|---|---|---|---|---|---|---|---|---|---|\n");
  for (const uint64_t seed : options.seeds) {
    drive.seed = seed;
    if (absl::Status status = Judge(drive); !status.ok()) {
      std::cerr << status << "\n";
      return 1;
    }
    std::cout.flush();
  }
  return 0;
}

}  // namespace
}  // namespace isthmus::bench

int main(int argc, char** argv) { return isthmus::bench::Main(argc, argv); }
