// The cost of durability: the same scans of eight robots into a pipeline whose store is on the disk
// and into one whose store forgets; see lab/docs/durability.md.
#include <stdlib.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "absl/strings/str_format.h"
#include "core/codec/payload_builder.h"
#include "lab/bench/cpu_clock.h"
#include "lab/bench/merging/figures.h"
#include "lab/simulation/simulator.h"
#include "server/pipeline.h"
#include "storage/memory_store.h"
#include "storage/sqlite/sqlite_store.h"
#include "tests/storage/faulty_store.h"

namespace isthmus::bench {
namespace {

using Drives = std::vector<std::vector<ScanUpload>>;  // By robot.

struct Settings {
  int robots = 8;
  int scans = 60;  // Per robot.
  int runs = 5;    // Per store, one after the other in turn.
  int threads = 2;
  std::string folder;
};

struct Measured {
  double wall_s = 0, cpu_s = 0;
  int64_t writes = 0;     // Batches that were asked to be durable.
  double written_mb = 0;  // By this process, to the disk.
};

Drives MakeDrives(const Settings& settings) {
  simulation::Options options;
  options.robots = settings.robots;
  options.seed = 5;
  const auto simulator = simulation::Simulator::Create(options).value();
  Drives drives(static_cast<size_t>(settings.robots));
  for (int robot = 0; robot < settings.robots; ++robot) {
    for (int index = 0; index < settings.scans; ++index) {
      const Scan scan = simulator->MakeScan(robot, index);
      drives[static_cast<size_t>(robot)].push_back(
          {scan.sequence, scan.end_stamp_ns, codec::MakePayload(scan)});
    }
  }
  return drives;
}

// Ingest alone: what the slow loop looks for would cost the same with either store.
server::PipelineOptions OptionsFor(const Settings& settings) {
  server::PipelineOptions options;
  options.ingest_threads = settings.threads;
  options.rematch_submaps = 1'000'000;
  options.loops.enabled = false;
  options.revisits.retire = false;
  return options;
}

double WrittenMb() {
  std::ifstream in("/proc/self/io");
  for (std::string key; in >> key;) {
    double bytes = 0;
    in >> bytes;
    if (key == "write_bytes:") return 1e-6 * bytes;
  }
  return 0;
}

template <typename T>
T OrThrow(absl::StatusOr<T> value) {
  if (!value.ok()) throw std::runtime_error(value.status().ToString());
  return *std::move(value);
}

// From the first scan until every session is finished: all is durable then.
Measured Run(const Settings& settings, const Drives& drives,
             std::unique_ptr<storage::MapStore> store) {
  const auto counted = std::make_shared<storage::Faults>();
  const auto pipeline = OrThrow(server::Pipeline::Open(
      OptionsFor(settings), storage::MakeFaultyStore(std::move(store), counted)));
  std::vector<SessionId> sessions;
  for (int robot = 0; robot < settings.robots; ++robot) {
    SessionRequest request;
    request.robot = RobotId(absl::StrFormat("robot-%d", robot));
    request.sensor = "vlp16";
    sessions.push_back(OrThrow(pipeline->sessions().Create(request)).record.id);
  }
  Measured measured;
  const double written_mb = WrittenMb();
  const CpuClock cpu(CpuClock::Of::kProcess);
  const auto begin = std::chrono::steady_clock::now();
  std::vector<std::thread> robots;
  for (size_t robot = 0; robot < sessions.size(); ++robot) {
    robots.emplace_back([&, robot] {
      for (const ScanUpload& scan : drives[robot]) {
        if (!pipeline->sessions().SubmitScan(sessions[robot], scan).ok()) std::abort();
      }
      if (!pipeline->sessions().Finish(sessions[robot]).ok()) std::abort();
    });
  }
  for (std::thread& robot : robots) robot.join();
  measured.wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  measured.cpu_s = 1e-3 * cpu.Ms();
  measured.writes = counted->writes();
  measured.written_mb = WrittenMb() - written_mb;
  return measured;
}

Measured RunOnDisk(const Settings& settings, const Drives& drives) {
  const std::string folder = settings.folder + "/durability_benchmark";
  std::filesystem::remove_all(folder);
  Measured measured = Run(settings, drives, OrThrow(storage::OpenSqliteStore(folder)));
  std::filesystem::remove_all(folder);
  return measured;
}

void Benchmark(const Settings& settings) {
  const Drives drives = MakeDrives(settings);
  const double scans = settings.robots * settings.scans;
  std::vector<double> memory_rate, disk_rate, wall_ratio, cpu_ratio, writes_rate, written_mb;
  for (int run = 0; run < settings.runs; ++run) {
    const Measured memory = Run(settings, drives, storage::MakeMemoryStore());
    const Measured disk = RunOnDisk(settings, drives);
    memory_rate.push_back(scans / memory.wall_s);
    disk_rate.push_back(scans / disk.wall_s);
    wall_ratio.push_back(memory.wall_s / disk.wall_s);
    cpu_ratio.push_back(memory.cpu_s / disk.cpu_s);
    writes_rate.push_back(static_cast<double>(disk.writes) / disk.wall_s);
    written_mb.push_back(disk.written_mb);
    absl::FPrintF(stderr, "run %d: %.1f scans/s in memory, %.1f on the disk, ratio %.3f\n", run + 1,
                  memory_rate.back(), disk_rate.back(), wall_ratio.back());
  }
  absl::PrintF(
      "| robots | scans | in memory (scans/s) | on the disk (scans/s) | ratio | ratio of CPU time "
      "| "
      "durable writes/s | written (MB) |\n|---|---|---|---|---|---|---|---|\n"
      "| %d | %d | %.0f | %.0f | %.3f | %.3f | %.1f | %.1f |\n",
      settings.robots, static_cast<int>(scans), Median(memory_rate), Median(disk_rate),
      Median(wall_ratio), Median(cpu_ratio), Median(writes_rate), Median(written_mb));
}

}  // namespace
}  // namespace isthmus::bench

int main(int argc, char** argv) {
  isthmus::bench::Settings settings;
  CLI::App app("What durability costs.", "durability_benchmark");
  app.add_option("--robots", settings.robots)->check(CLI::Range(1, 64))->capture_default_str();
  app.add_option("--scans", settings.scans, "Of each robot")
      ->check(CLI::Range(1, 100'000))
      ->capture_default_str();
  app.add_option("--runs", settings.runs, "Of each store; medians are told")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  app.add_option("--threads", settings.threads, "For odometry")
      ->check(CLI::Range(1, 256))
      ->capture_default_str();
  app.add_option("--folder", settings.folder, "On the disk that is measured")->required();
  CLI11_PARSE(app, argc, argv);
  isthmus::bench::Benchmark(settings);
  return 0;
}
