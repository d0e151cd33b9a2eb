// A server on a map that is larger than its memory: how much it takes, and how soon regions are
// read. See lab/docs/large_map.md.
#include <absl/strings/str_format.h>
#include <sys/wait.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include "core/stopwatch.h"
#include "lab/bench/large_map/large_store.h"
#include "lab/bench/memory.h"
#include "lab/bench/merging/temporary_folder.h"
#include "server/pipeline.h"
#include "storage/sqlite/sqlite_store.h"

namespace isthmus::bench {
namespace {

struct Arguments {
  double gb = 1;
  int cache_mb = 512;
  int queries = 2000;
  unsigned seed = 1;
  bool estimate = false;
  std::string folder;  // Empty: a temporary one.
};

// In a process of its own, whose memory is not the server's.
bool Generate(const Arguments& arguments, const std::string& folder) {
  const pid_t child = fork();
  if (child == 0) {
    LargeStoreOptions options;
    options.bytes = arguments.gb * 1e9;
    options.seed = arguments.seed;
    const absl::Status status = FillStore(options, folder);
    if (!status.ok()) std::fprintf(stderr, "%s\n", status.ToString().c_str());
    _exit(status.ok() ? 0 : 1);
  }
  int result = 0;
  return child > 0 && waitpid(child, &result, 0) == child && result == 0;
}

// Boxes and spheres of 20 to 50 m, on the robots' ways.
std::vector<Region> RandomRegions(const std::vector<SubmapStatus>& submaps, int count,
                                  unsigned seed) {
  std::mt19937 rng(seed);
  std::uniform_real_distribution<double> size(20, 50), offset(-20, 20);
  std::vector<Region> regions;
  while (static_cast<int>(regions.size()) < count && !submaps.empty()) {
    const SubmapStatus& submap = submaps[rng() % submaps.size()];
    if (!submap.component) continue;
    Region& region = regions.emplace_back();
    region.component = *submap.component;
    const Eigen::Vector3d center =
        submap.T_map_submap.translation() + Eigen::Vector3d(offset(rng), offset(rng), 0);
    const double edge = size(rng);
    if (regions.size() % 2 == 0) {
      region.has_sphere = true;
      region.center = center;
      region.radius_m = edge / 2;
    } else {
      region.box.Extend(center - Eigen::Vector3d::Constant(edge / 2));
      region.box.Extend(center + Eigen::Vector3d::Constant(edge / 2));
    }
  }
  return regions;
}

struct Reading {
  std::vector<double> ms;  // Sorted.
  double points = 0;       // Sum over all regions.
};

absl::StatusOr<Reading> ReadRegions(const std::vector<Region>& regions,
                                    server::Pipeline& pipeline) {
  constexpr size_t kChunk = 50'000;  // As the RPC.
  Reading reading;
  for (const Region& region : regions) {
    const Stopwatch watch;
    const auto count = [&](const std::vector<MapPoint>& points) {
      reading.points += static_cast<double>(points.size());
      return true;
    };
    const absl::Status status = pipeline.reader().Map()->Read(region, kChunk, count);
    if (!status.ok()) return status;
    reading.ms.push_back(watch.Ms());
  }
  std::sort(reading.ms.begin(), reading.ms.end());
  return reading;
}

double Quantile(const std::vector<double>& sorted, double share) {
  return sorted[static_cast<size_t>(share * static_cast<double>(sorted.size() - 1))];
}

// Until the map can be read.
absl::Status WaitUntilReady(server::Pipeline& pipeline) {
  absl::Status ready;
  while (absl::IsUnavailable(ready = pipeline.reader().Map()->ready())) {
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
  return ready;
}

absl::Status Measure(const Arguments& arguments, const std::string& folder) {
  server::PipelineOptions options;
  server::SetCache(size_t(arguments.cache_mb) << 20, folder, &options);
  // Estimation spends a second, once, to prepare each submap; that is not measured here.
  options.loops.enabled = options.revisits.retire = arguments.estimate;
  options.on_problem = [](const std::string& problem) {
    std::fprintf(stderr, "%s\n", problem.c_str());
  };
  ResetPeak();
  const Stopwatch watch;
  auto store = storage::OpenSqliteStore(folder);
  if (!store.ok()) return store.status();
  auto pipeline = server::Pipeline::Open(options, *std::move(store));
  if (!pipeline.ok()) return pipeline.status();
  const double open_s = watch.Ms() / 1e3;
  std::fprintf(stderr, "answers after %.1f s, %.0f MB\n", open_s, PeakMb());
  absl::Status status = WaitUntilReady(**pipeline);
  if (!status.ok()) return status;
  const double ready_s = watch.Ms() / 1e3, start_peak_mb = PeakMb();
  std::fprintf(stderr, "composed after %.1f s, %.0f MB at most\n", ready_s, start_peak_mb);
  if (arguments.estimate) (*pipeline)->WaitUntilIdle();
  const double idle_mb = ResidentMb();

  ResetPeak();
  const auto submaps = (*pipeline)->reader().ListSubmaps(std::nullopt);
  if (!submaps.ok()) return submaps.status();
  const auto regions = RandomRegions(*submaps, arguments.queries, arguments.seed);
  const auto reading = ReadRegions(regions, **pipeline);
  if (!reading.ok()) return reading.status();
  if (reading->ms.empty()) return absl::InvalidArgumentError("no queries, or an empty map");
  const MapInfo info = (*pipeline)->GetMapInfo();
  uint64_t points = 0, submap_points = 0;
  for (const Component& component : info.components) points += component.point_count;
  for (const SubmapStatus& submap : *submaps) submap_points += submap.info.point_count;
  std::printf("revision %lld, %zu components, %.0f M points measured, composed in %.1f s\n",
              static_cast<long long>(info.revision), info.components.size(), submap_points / 1e6,
              info.composition_ms / 1e3);
  std::printf(
      "| GB | submaps | M points in the map | cache MiB | answers s | composed s | MB start | "
      "MB idle | MB queries | points a query | p50 ms | p99 ms | max ms |\n"
      "|---|---|---|---|---|---|---|---|---|---|---|---|---|\n"
      "| %.1f | %zu | %.1f | %d | %.1f | %.0f | %.0f | %.0f | %.0f | %.0f | %.1f | %.1f | %.1f |\n",
      BytesOnDisk(folder) / 1e9, submaps->size(), points / 1e6, arguments.cache_mb, open_s, ready_s,
      start_peak_mb, idle_mb, PeakMb(), reading->points / reading->ms.size(),
      Quantile(reading->ms, 0.5), Quantile(reading->ms, 0.99), reading->ms.back());
  return absl::OkStatus();
}

int Run(const Arguments& arguments) {
  const TemporaryFolder temporary;
  const std::string folder = arguments.folder.empty() ? temporary.path() : arguments.folder;
  std::filesystem::create_directories(folder);
  const bool is_there = std::filesystem::exists(folder + "/isthmus.db");
  if (!is_there) {
    const Stopwatch watch;
    if (!Generate(arguments, folder)) return 1;
    std::fprintf(stderr, "generated in %.0f s\n", watch.Ms() / 1e3);
  }
  const absl::Status status = Measure(arguments, folder);
  if (!status.ok()) std::fprintf(stderr, "%s\n", status.ToString().c_str());
  return status.ok() ? 0 : 1;
}

}  // namespace
}  // namespace isthmus::bench

int main(int argc, char** argv) {
  isthmus::bench::Arguments arguments;
  CLI::App app("Generates a map of a city and reads regions of it from a restarted server.");
  app.add_option("--gb", arguments.gb, "Size of the store on disk")->capture_default_str();
  app.add_option("--cache-mb", arguments.cache_mb, "The server's cache")->capture_default_str();
  app.add_option("--queries", arguments.queries, "Regions to read")->capture_default_str();
  app.add_option("--seed", arguments.seed, "Of points and regions")->capture_default_str();
  app.add_flag("--estimate", arguments.estimate,
               "Look for loop closures and revisits too, and wait for that");
  app.add_option("--keep", arguments.folder,
                 "Folder for the store, which stays; one that is there is used again");
  CLI11_PARSE(app, argc, argv);
  return isthmus::bench::Run(arguments);
}
