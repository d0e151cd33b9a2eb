// The effect of readers of a large map on robots: how soon scans are acknowledged without readers,
// and while some ask for lists without a pause.
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "absl/strings/str_format.h"
#include "lab/bench/cpu_clock.h"
#include "lab/bench/merging/temporary_folder.h"
#include "lab/bench/readers/fleet.h"
#include "lab/bench/readers/known_map.h"
#include "server/pipeline.h"
#include "storage/memory_store.h"
#include "storage/sqlite/sqlite_store.h"

namespace isthmus::bench {
namespace {

struct Settings {
  KnownMapOptions map;
  FleetOptions fleet;
  int scans = 200;  // Per robot in each row.
  int readers = 4;
  bool on_disk = false;
};

// Threads that list what there is of the map, as fast as they can.
class Readers {
 public:
  // `nice`: how much they give way to others, 0 to 19.
  Readers(int count, int nice, server::Pipeline* pipeline) {
    for (int i = 0; i < count; ++i) {
      threads_.emplace_back([this, nice, pipeline] {
        (void)setpriority(PRIO_PROCESS, static_cast<id_t>(syscall(SYS_gettid)), nice);
        while (!stop_) Read(*pipeline);
      });
    }
  }
  ~Readers() {
    stop_ = true;
    for (std::thread& thread : threads_) thread.join();
  }
  int answers() const { return answers_; }

 private:
  void Read(server::Pipeline& pipeline) {
    const bool all = pipeline.reader().ListSubmaps(std::nullopt).ok() &&
                     pipeline.reader().ListLoops(std::nullopt).ok() &&
                     !pipeline.reader().GetMatchGraph().matches.empty();
    if (!all) std::abort();
    answers_ += 3;
  }

  std::atomic<bool> stop_ = false;
  std::atomic<int> answers_ = 0;
  std::vector<std::thread> threads_;
};

double Quantile(const std::vector<double>& sorted, double share) {
  return sorted.at(static_cast<size_t>(share * static_cast<double>(sorted.size() - 1)));
}

// Returns the 99th percentile.
double Measure(const std::string& name, Fleet* fleet, const Settings& settings, int readers,
               int nice, server::Pipeline* pipeline, std::optional<double> p99_without) {
  const uint64_t submaps = pipeline->GetMapInfo().submaps;
  const CpuClock cpu(CpuClock::Of::kProcess);
  const Readers reading(readers, nice, pipeline);
  const std::vector<double> ms = fleet->Drive(settings.scans);
  const double p99 = Quantile(ms, 0.99);
  const double seconds = settings.scans / settings.fleet.rate_hz;
  absl::PrintF("| %s | %d | %.1f | %.1f | %.1f | %.1f | %.2f | %.0f | %.0f | %.2f |\n", name,
               static_cast<int>(ms.size()), Quantile(ms, 0.5), Quantile(ms, 0.9), p99, ms.back(),
               p99 / p99_without.value_or(p99), reading.answers() / seconds,
               static_cast<double>(pipeline->GetMapInfo().submaps - submaps),
               cpu.Ms() / 1e3 / seconds);
  std::fflush(stdout);
  return p99;
}

// Matching and loop closure would hide what is measured here.
server::PipelineOptions QuietOptions() {
  server::PipelineOptions options;
  options.rematch_submaps = 1'000'000;
  options.loops.enabled = false;
  options.revisits.retire = false;
  options.submap.cut_scans = 25;
  return options;
}

void Benchmark(const Settings& settings, std::unique_ptr<storage::MapStore> store) {
  if (!WriteKnownMap(settings.map, store.get()).ok()) std::abort();
  const auto pipeline = server::Pipeline::Open(QuietOptions(), std::move(store)).value();
  pipeline->WaitUntilIdle();
  FleetOptions fleet_options = settings.fleet;
  const int warm_up = 40;
  fleet_options.scans = warm_up + 3 * settings.scans;
  Fleet fleet(fleet_options, pipeline.get());
  // The first submaps are compared with every session there is.
  (void)fleet.Drive(warm_up);
  pipeline->WaitUntilIdle();
  const MapInfo info = pipeline->GetMapInfo();
  absl::FPrintF(stderr, "%d submaps in %d components\n", static_cast<int>(info.submaps),
                static_cast<int>(info.components.size()));
  absl::PrintF(
      "| readers | acknowledgements | p50 ms | p90 ms | p99 ms | max ms | p99 ratio | answers/s | "
      "new submaps | cores |\n|---|---|---|---|---|---|---|---|---|---|\n");
  const double p99 = Measure("none", &fleet, settings, 0, 0, pipeline.get(), std::nullopt);
  (void)Measure(absl::StrFormat("%d", settings.readers), &fleet, settings, settings.readers, 0,
                pipeline.get(), p99);
  (void)Measure(absl::StrFormat("%d, nice 19", settings.readers), &fleet, settings,
                settings.readers, 19, pipeline.get(), p99);
  absl::FPrintF(stderr, "%.1f ms of odometry a scan, %.1f %% of scans followed\n",
                fleet.odometry_ms(), 100 * fleet.tracked());
}

void Run(const Settings& settings) {
  if (!settings.on_disk) return Benchmark(settings, storage::MakeMemoryStore());
  const TemporaryFolder folder;
  Benchmark(settings,
            storage::OpenSqliteStore(folder.path(), {.sync_every_commit = false}).value());
}

}  // namespace
}  // namespace isthmus::bench

int main(int argc, char** argv) {
  isthmus::bench::Settings settings;
  CLI::App app("How soon scans are acknowledged while others list a large map.");
  app.add_option("--sessions", settings.map.sessions, "Of the map")->capture_default_str();
  app.add_option("--submaps", settings.map.submaps, "Of each session")->capture_default_str();
  app.add_option("--robots", settings.fleet.robots)->capture_default_str();
  app.add_option("--rate", settings.fleet.rate_hz, "Of each robot, Hz")->capture_default_str();
  app.add_option("--scans", settings.scans, "Of each robot in each row")->capture_default_str();
  app.add_option("--readers", settings.readers)->capture_default_str();
  app.add_flag("--disk", settings.on_disk, "The store is on the disk, not in memory");
  CLI11_PARSE(app, argc, argv);
  isthmus::bench::Run(settings);
  return 0;
}
