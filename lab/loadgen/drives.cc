#include "lab/loadgen/drives.h"

#include <absl/strings/str_cat.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <thread>
#include <utility>

#include "client/console/recording_options.h"
#include "core/codec/payload_builder.h"
#include "core/codec/quantized.h"
#include "lab/loadgen/limits.h"
#include "lab/simulation/simulator.h"

namespace isthmus::loadgen {
namespace {

absl::StatusOr<PointPayload> Encoded(PointPayload payload) {
  if (payload.encoding != PayloadEncoding::kRaw) return payload;
  return codec::Quantize(payload, kResolutionM);
}

// Calls `work(i)` for 0 <= i < count, on all cores.
template <typename Work>
void InParallel(int count, const Work& work) {
  std::atomic<int> next = 0;
  std::vector<std::thread> threads;
  for (unsigned i = 0; i < std::max(1u, std::thread::hardware_concurrency()); ++i) {
    threads.emplace_back([&] {
      for (int at = next++; at < count; at = next++) work(at);
    });
  }
  for (std::thread& thread : threads) thread.join();
}

absl::StatusOr<Drive> ReadDrive(const std::string& path, double seconds) {
  auto robots = cli::OpenRobots(path, {});
  if (!robots.ok()) return robots.status();
  readers::ScanReader& reader = *robots->front().reader;
  Drive drive;
  drive.sensor = robots->front().sensor;
  const auto length_ns = static_cast<int64_t>(seconds * 1e9);
  for (;;) {
    auto scan = reader.Next();
    if (!scan.ok()) continue;  // Damaged; the next one is behind it.
    if (!scan->has_value()) break;
    if (!drive.scans.empty() &&
        (*scan)->end_stamp_ns > drive.scans.front().end_stamp_ns + length_ns) {
      break;
    }
    auto payload = Encoded(std::move((*scan)->payload));
    if (!payload.ok()) continue;
    drive.scans.push_back({(*scan)->end_stamp_ns, *std::move(payload)});
  }
  if (drive.scans.empty()) {
    return absl::InvalidArgumentError(absl::StrCat("no scan in ", path, " can be read"));
  }
  return drive;
}

}  // namespace

absl::StatusOr<Drives> SimulateDrives(const SimulatedDrives& options) {
  simulation::Options wanted;
  wanted.world = options.world;
  wanted.sensor = options.sensor;
  wanted.robots = options.drives;
  wanted.seconds = options.seconds;
  wanted.seed = options.seed;
  const auto simulator = simulation::Simulator::Create(wanted);
  if (!simulator.ok()) return simulator.status();
  const int scans = (*simulator)->scan_count();
  std::vector<Drive> drives(static_cast<size_t>(options.drives));
  for (Drive& drive : drives) {
    drive.sensor = options.sensor;
    drive.scans.resize(static_cast<size_t>(scans));
  }
  InParallel(scans * options.drives, [&](int i) {
    const int robot = i / scans, index = i % scans;
    const Scan scan = (*simulator)->MakeScan(robot, index);
    Drive::OneScan& one = drives[static_cast<size_t>(robot)].scans[static_cast<size_t>(index)];
    one.end_stamp_ns = scan.end_stamp_ns;
    // Simulated scans can be rounded: their coordinates are within the sensor's range.
    one.payload = *Encoded(codec::MakePayload(scan));
  });
  Drives shared;
  for (Drive& drive : drives) shared.push_back(std::make_shared<const Drive>(std::move(drive)));
  return shared;
}

Drives MakeDenseDrive(int points) {
  std::vector<ScanPoint> scan(static_cast<size_t>(points));
  for (size_t i = 0; i < scan.size(); ++i) {
    const double angle = 2 * M_PI * static_cast<double>(i) / points;
    const double up = std::tan((static_cast<double>(i % 16) * 2 - 15) * M_PI / 180);
    const double range = std::min(10 / std::abs(std::cos(angle)), 15 / std::abs(std::sin(angle)));
    scan[i].x = static_cast<float>(range * std::cos(angle));
    scan[i].y = static_cast<float>(range * std::sin(angle));
    scan[i].z = static_cast<float>(range * up);
  }
  Drive drive;
  drive.sensor = "vlp16";
  drive.scans.push_back({1'700'000'000'000'000'000, codec::MakePayload(scan, false, false)});
  return {std::make_shared<const Drive>(std::move(drive))};
}

absl::StatusOr<Drives> ReadDrives(const std::vector<std::string>& recordings, double seconds) {
  Drives drives;
  for (const std::string& path : recordings) {
    auto drive = ReadDrive(path, seconds);
    if (!drive.ok()) return drive.status();
    drives.push_back(std::make_shared<const Drive>(*std::move(drive)));
  }
  return drives;
}

}  // namespace isthmus::loadgen
