#include "lab/commands/bench_paper.h"

#include <absl/strings/str_cat.h>

#include <algorithm>
#include <chrono>
#include <memory>
#include <utility>

#include "client/console/waiting.h"
#include "client/offline/embedded_server.h"
#include "core/concurrency/mutex.h"
#include "lab/simulation/simulator.h"

namespace isthmus::cli {
namespace {

using simulation::Simulator;

constexpr int kRobots = 2;
constexpr double kSettleTimeoutS = 3600;
// A scan without an answer for so long is not waited for any longer; Finish then tells why.
constexpr std::chrono::seconds kAckTimeout(60);

// Totals over the acknowledgements of one robot; added to by the stream's thread.
class AckTotals {
 public:
  void Add(const ScanAck& ack) {
    MutexLock lock(&mutex_);
    ++answered_;
    if (ack.outcome == ScanOutcome::kProcessed) {
      ++processed_;
      if (ack.tracking == Tracking::kLost) ++lost_;
      sum_.total_ms += ack.timing.total_ms;
      sum_.features_ms += ack.timing.features_ms;
      sum_.matching_ms += ack.timing.matching_ms;
      sum_.map_ms += ack.timing.map_ms;
      max_ms_ = std::max(max_ms_, ack.timing.total_ms);
    }
    changed_.SignalAll();
  }

  void WaitFor(uint64_t answers) {
    MutexLock lock(&mutex_);
    const auto until = std::chrono::steady_clock::now() + kAckTimeout;
    while (answered_ < answers && std::chrono::steady_clock::now() < until) {
      changed_.WaitFor(&mutex_, until - std::chrono::steady_clock::now());
    }
  }

  void Report(PaperBenchRobot* robot) {
    MutexLock lock(&mutex_);
    robot->scans = processed_;
    robot->lost = lost_;
    const double scans = std::max(1.0, static_cast<double>(processed_));
    robot->mean_ms = sum_.total_ms / scans;
    robot->features_ms = sum_.features_ms / scans;
    robot->matching_ms = sum_.matching_ms / scans;
    robot->map_ms = sum_.map_ms / scans;
    robot->max_ms = max_ms_;
  }

 private:
  Mutex mutex_;
  CondVar changed_;
  uint64_t answered_ ABSL_GUARDED_BY(mutex_) = 0,
                     processed_ ABSL_GUARDED_BY(mutex_) = 0, lost_ ABSL_GUARDED_BY(mutex_) = 0;
  ScanTiming sum_ ABSL_GUARDED_BY(mutex_) = {};
  double max_ms_ ABSL_GUARDED_BY(mutex_) = 0;
};

absl::Status Drive(client::Client& client, const Simulator& simulator, int index, OdometryMode mode,
                   const BenchProgress& progress, PaperBenchRobot* robot) {
  auto session = client.CreateSession(robot->name, simulator.options().sensor, Pose(), mode);
  if (!session.ok()) return session.status();
  AckTotals totals;
  client::ScanStreamOptions options;
  options.on_ack = [&totals](const ScanAck& ack) { totals.Add(ack); };
  auto stream = client.OpenScanStream(session->record.id, options);
  if (!stream.ok()) return stream.status();
  const int count = simulator.scan_count();
  for (int k = 0; k < count; ++k) {
    progress(index * count + k, kRobots * count);
    if (absl::Status status = (*stream)->Push(simulator.MakeScan(index, k)); !status.ok()) {
      return status;
    }
    totals.WaitFor(static_cast<uint64_t>(k) + 1);
  }
  if (absl::Status status = (*stream)->Finish(); !status.ok()) return status;
  session = client.FinishSession(session->record.id);
  if (!session.ok()) return session.status();
  robot->travelled_m = session->travelled_m;
  totals.Report(robot);
  return absl::OkStatus();
}

absl::StatusOr<std::vector<evaluation::TrajectoryPair>> Trajectories(client::Client& client,
                                                                     const Simulator& simulator,
                                                                     const PaperBenchRun& run,
                                                                     TrajectoryFrame frame) {
  std::vector<evaluation::TrajectoryPair> pairs;
  for (int i = 0; i < kRobots; ++i) {
    const std::string& name = run.robots[i].name;
    auto trajectory = client.GetTrajectory(RobotId(name), frame);
    if (!trajectory.ok()) return trajectory.status();
    pairs.push_back({name, simulator.Truth(i), std::move(trajectory->poses)});
  }
  return pairs;
}

// The time that matching the two maps took last, stage by stage.
absl::StatusOr<std::vector<StageTime>> EstimationStages(client::Client& client) {
  const auto graph = client.GetMatchGraph();
  if (!graph.ok()) return graph.status();
  std::vector<StageTime> stages;
  for (const MatchEdge& edge : graph->matches) {
    for (const StageTime& stage : edge.match.stages) {
      const auto same = std::ranges::find(stages, stage.stage, &StageTime::stage);
      if (same == stages.end()) {
        stages.push_back(stage);
      } else {
        same->ms += stage.ms;
      }
    }
  }
  return stages;
}

absl::Status CompareWithTruth(client::Client& client, const Simulator& simulator, bool merged,
                              PaperBenchRun* run) {
  const auto own = Trajectories(client, simulator, *run, TrajectoryFrame::kOdom);
  if (!own.ok()) return own.status();
  for (int i = 0; i < kRobots; ++i) {
    const auto errors = evaluation::CompareTrajectories({(*own)[i]});
    if (!errors.ok()) return errors.status();
    run->robots[i].own = errors->all;
  }
  if (!merged) return absl::OkStatus();
  const auto placed = Trajectories(client, simulator, *run, TrajectoryFrame::kMap);
  if (!placed.ok()) return placed.status();
  const auto errors = evaluation::CompareTrajectories(*placed);
  if (!errors.ok()) return errors.status();
  for (int i = 0; i < kRobots; ++i) run->robots[i].in_map = errors->robots[i];
  run->all = errors->all;
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<PaperBenchRun> RunPaperBench(const std::string& world, const std::string& mode,
                                            uint64_t seed, double seconds,
                                            const BenchProgress& progress) {
  simulation::Options options;
  options.world = world;
  options.seed = seed;
  options.seconds = seconds;
  options.robots = kRobots;
  const auto odometry = ParseOdometryMode(mode);
  if (!odometry.ok()) return odometry.status();
  const auto simulator = Simulator::Create(options);
  if (!simulator.ok()) return simulator.status();
  const auto server = EmbeddedServer::Start({});
  if (!server.ok()) return server.status();
  client::Client& client = (*server)->client();

  PaperBenchRun run;
  run.world = world;
  run.mode = mode;
  run.seed = seed;
  for (int i = 0; i < kRobots; ++i) {
    run.robots.emplace_back().name = absl::StrCat("robot_", i);
    const absl::Status status =
        Drive(client, **simulator, i, *odometry, progress, &run.robots.back());
    if (!status.ok()) return status;
  }
  const auto info = Wait(client, WaitFor::kSettled, kSettleTimeoutS);
  if (!info.ok()) return info.status();
  auto stages = EstimationStages(client);
  if (!stages.ok()) return stages.status();
  run.stages = *std::move(stages);
  for (const StageTime& stage : run.stages) run.estimation_ms += stage.ms;
  run.composition_ms = info->composition_ms;
  run.composition_max_ms = info->composition_max_ms;
  const absl::Status status = CompareWithTruth(client, **simulator, IsMerged(*info), &run);
  if (!status.ok()) return status;
  return run;
}

}  // namespace isthmus::cli
