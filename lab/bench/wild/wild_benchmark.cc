#include "lab/bench/wild/wild_benchmark.h"

#include <atomic>
#include <iostream>
#include <random>
#include <thread>

#include "core/concurrency/mutex.h"

namespace isthmus::bench {
namespace {

absl::StatusOr<WildEntry> RunOne(uint64_t seed, const WildBenchmarkOptions& options,
                                 const floam::OdometryOptions& odometry) {
  auto ride = GetWildRide(seed, options.drawn, options.cache);
  if (!ride.ok()) return ride.status();
  KeepEvery(&ride->drive.shots, options.every);
  const auto run = Run(ride->drive, odometry);
  if (!run.ok()) return run.status();
  constexpr double kPeriodS = 0.1;  // Scan period of every sensor model.
  return WildEntry{.kind = ride->kind,
                   .carrier = ride->carrier,
                   .about = ride->about,
                   .sensor = ride->drive.sensor,
                   .seed = seed,
                   .cal_ms = run->cal_ms,
                   .score = ScoreWildDrive(run->scans, options.every * kPeriodS)};
}

std::vector<uint64_t> Seeds(const WildBenchmarkOptions& options) {
  std::random_device device;
  std::vector<uint64_t> seeds;
  for (int i = 0; i < options.drives; ++i) {
    // Ten digits at most: to be read, remembered and typed again.
    seeds.push_back(options.seed ? *options.seed + static_cast<uint64_t>(i) : device());
  }
  return seeds;
}

}  // namespace

absl::StatusOr<std::vector<WildEntry>> RunWildDrives(const WildBenchmarkOptions& options,
                                                     const floam::OdometryOptions& odometry) {
  const std::vector<uint64_t> seeds = Seeds(options);
  std::vector<WildEntry> entries(seeds.size());
  std::atomic<size_t> next = 0;
  Mutex mutex;
  absl::Status failed;  // The first; guarded by `mutex`.
  const auto work = [&] {
    for (size_t i = next++; i < seeds.size(); i = next++) {
      auto entry = RunOne(seeds[i], options, odometry);
      MutexLock lock(&mutex);
      if (!failed.ok()) return;
      if (!entry.ok()) {
        failed = entry.status();
        return;
      }
      entries[i] = *std::move(entry);
      std::cerr << ToLine(entries[i]) << std::endl;
    }
  };
  std::vector<std::thread> workers;
  for (int i = 1; i < options.jobs; ++i) workers.emplace_back(work);
  work();
  for (std::thread& worker : workers) worker.join();
  MutexLock lock(&mutex);
  if (!failed.ok()) return failed;
  return entries;
}

}  // namespace isthmus::bench
