// The cost of letting a robot's session survive a crash of the server; see
// lab/docs/checkpoint.md.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <string>
#include <vector>

#include "absl/strings/str_format.h"
#include "lab/bench/cpu_clock.h"
#include "lab/bench/scenarios.h"
#include "server/ingest/odometry_checkpoint_state.h"

namespace isthmus::bench {
namespace {

struct Costs {
  double odometry_ms = 0;  // All scans, submaps included.
  double save_ms = 0, pack_ms = 0,
         open_ms = 0;                // Checkpoints: odometry's part, all; the last back.
  double raw_mb = 0, packed_mb = 0;  // The last checkpoint's.
  int scans = 0, checkpoints = 0;
};

Costs Measure(const Drive& drive) {
  SessionRecord record;
  const floam::SensorModel sensor = floam::FindSensorModel(drive.sensor).value();
  const auto make = [&] {
    return ingest::OdometryCheckpointState(record, sensor, {}, floam::SubmapOptions(), 1, 0);
  };
  ingest::OdometryCheckpointState state = make();
  Costs costs;
  std::string saved;
  if (drive.record) drive.record();
  for (const Shot& shot : drive.shots) {
    const Scan scan = MakeScan(drive, shot, ++costs.scans);
    const CpuClock tracking;
    const auto result = state.odometry.Process(scan);
    const auto submap = result.ok() ? state.builder->Add(*result) : nullptr;
    if (submap != nullptr) state.odometry.Remember(*submap);
    costs.odometry_ms += tracking.Ms();
    if (submap == nullptr) continue;
    const CpuClock saving;
    costs.raw_mb = 1e-6 * static_cast<double>(state.odometry.Save().size());
    costs.save_ms += saving.Ms();
    const CpuClock packing;
    saved = state.Save().value();
    costs.pack_ms += packing.Ms();
    costs.packed_mb = 1e-6 * static_cast<double>(saved.size());
    ++costs.checkpoints;
  }
  ingest::OdometryCheckpointState other = make();
  const CpuClock opening;
  if (saved.empty() || !other.Restore(saved, [] {}).ok()) std::abort();
  costs.open_ms = opening.Ms();
  return costs;
}

}  // namespace

int Main(int argc, char** argv) {
  CLI::App app("What checkpoints cost, a line per simulated drive.");
  std::vector<std::string> names = {"museum", "campus"};
  ScenarioOptions options;
  app.add_option("scenarios", names, "as odometry_benchmark lists them")->capture_default_str();
  app.add_option("--seconds", options.seconds, "of the drive; 0: as long as is usual");
  app.add_option("--sensor", options.sensor)->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  const auto scenarios = FindScenarios(names);
  if (!scenarios.ok())
    return std::fprintf(stderr, "%s\n", scenarios.status().ToString().c_str()), 1;
  for (const Scenario& scenario : *scenarios) {
    const auto drive = scenario.make(options, scenario.seeds.front());
    if (!drive.ok()) return std::fprintf(stderr, "%s\n", drive.status().ToString().c_str()), 1;
    const Costs c = Measure(*drive);
    const double n = std::max(1, c.checkpoints);
    absl::PrintF(
        "%-20s %d scans %.2f ms each | %d checkpoints: state %.1f ms, packed %.1f ms "
        "(%.1f %% of the odometry) | last %.2f MB, packed %.2f MB, back in %.1f ms\n",
        scenario.name, c.scans, c.odometry_ms / c.scans, c.checkpoints, c.save_ms / n,
        c.pack_ms / n, 100 * c.pack_ms / c.odometry_ms, c.raw_mb, c.packed_mb, c.open_ms);
  }
  return 0;
}

}  // namespace isthmus::bench

int main(int argc, char** argv) { return isthmus::bench::Main(argc, argv); }
