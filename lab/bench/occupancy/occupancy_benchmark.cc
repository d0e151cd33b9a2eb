// OctoMaps of simulated drives: from nothing, from what is kept, and by OctoMap's own insertion.
// lab/docs/occupancy.md says how to use it.
#include <absl/strings/str_format.h>

#include <CLI/CLI.hpp>
#include <iostream>
#include <string>
#include <vector>

#include "lab/bench/cpu_clock.h"
#include "lab/bench/moving/mapped_drive.h"
#include "lab/bench/occupancy/octomap_judge.h"
#include "server/composition/occupancy/kept_occupancy.h"

namespace isthmus::bench {
namespace {

struct Options {
  DriveOptions drive;
  std::vector<uint64_t> seeds = {1};
  std::vector<double> resolutions = {0.2, 0.1};
  bool by_octomap = false;
  composition::OccupancyFormat format = composition::OccupancyFormat::kBinary;
  composition::OccupancyOptions occupancy;
};

// CPU time of a file of these submaps.
absl::StatusOr<double> Time(const MappedTeam& world, const std::vector<PlacedSubmap>& submaps,
                            const Options& options, composition::KeptOccupancy* kept,
                            std::string* bytes) {
  const CpuClock clock;
  auto file = kept->Write(submaps, world.reader(), 0, options.format, options.occupancy);
  const double ms = clock.Ms();
  if (!file.ok()) return file.status();
  *bytes = *std::move(file);
  return ms;
}

// In turn: from nothing, all kept, the last robot's last submap comes, one in the middle moves.
absl::Status Measure(const Options& options, const MappedTeam& world, uint64_t seed) {
  composition::KeptOccupancy kept(uint64_t{4} << 30);
  std::vector<PlacedSubmap> submaps = world.placed;
  submaps.pop_back();
  std::string file, warm_file, moved_file;
  auto before = Time(world, submaps, options, &kept, &file);
  if (!before.ok()) return before.status();
  const auto comes = Time(world, world.placed, options, &kept, &file);
  submaps = world.placed;
  Pose& pose = submaps[submaps.size() / 2].T_map_submap;
  pose = Pose(Eigen::Vector3d(0.1, 0.1, 0)) * pose;
  const auto moves = Time(world, submaps, options, &kept, &moved_file);
  composition::KeptOccupancy other(uint64_t{4} << 30);
  const auto cold = Time(world, world.placed, options, &other, &file);
  const auto warm = Time(world, world.placed, options, &other, &warm_file);
  for (const auto* ms : {&comes, &moves, &cold, &warm}) {
    if (!ms->ok()) return ms->status();
  }
  absl::PrintF("| %s | %d | %d | %.2f | %.1f | %.1f | %.0f | %.0f | %.2f | %.2f |",
               options.drive.world, seed, world.placed.size(), options.occupancy.resolution_m,
               1e-6 * static_cast<double>(file.size()),
               1e-6 * static_cast<double>(other.kept_bytes()), *cold, *warm, *comes / *cold,
               *moves / *cold);
  if (options.by_octomap) {
    const OctomapJudgement judged =
        JudgeByOctomap(world.placed, world.reader(), options.occupancy, file);
    absl::PrintF(
        " %.1f | %.3f |", judged.ms / *cold,
        100. * static_cast<double>(judged.differing) / static_cast<double>(judged.occupied));
  }
  absl::PrintF("\n");
  return file == warm_file ? absl::OkStatus() : absl::InternalError("what is kept is another map");
}

int Main(int argc, char** argv) {
  CLI::App app("What OctoMaps of drives cost, and how they compare with OctoMap's own insertion");
  Options options;
  DriveOptions& drive = options.drive;
  app.add_option("--world", drive.world, "As simulate --world")->capture_default_str();
  app.add_option("--seeds", options.seeds)->capture_default_str();
  app.add_option("--seconds", drive.seconds, "Length of drives")->capture_default_str();
  app.add_option("--robots", drive.robots)->capture_default_str();
  app.add_option("--sensor", drive.sensor)->capture_default_str();
  app.add_option("--resolutions", options.resolutions, "m")->capture_default_str();
  app.add_option("--range", options.occupancy.max_range_m, "m")->capture_default_str();
  app.add_flag("--octomap", options.by_octomap, "Compare with OcTree::insertPointCloud");
  bool full = false;
  app.add_flag("--full", full, "Files of log-odds (.ot)");
  CLI11_PARSE(app, argc, argv);
  if (full) options.format = composition::OccupancyFormat::kFull;
  absl::PrintF(
      "| world | seed | submaps | m | file MB | kept MB | from nothing, ms | kept, ms | one "
      "came | one moved |%s\n|---|---|---|---|---|---|---|---|---|---|%s\n",
      options.by_octomap ? " OctoMap's | differing % |" : "", options.by_octomap ? "---|---|" : "");
  for (const uint64_t seed : options.seeds) {
    drive.seed = seed;
    const auto world = MapTeam(drive);
    absl::Status status = world.status();
    for (const double resolution : options.resolutions) {
      options.occupancy.resolution_m = resolution;
      if (status.ok()) status = Measure(options, *world, seed);
      std::cout.flush();
    }
    if (!status.ok()) {
      std::cerr << status << "\n";
      return 1;
    }
  }
  return 0;
}

}  // namespace
}  // namespace isthmus::bench

int main(int argc, char** argv) { return isthmus::bench::Main(argc, argv); }
