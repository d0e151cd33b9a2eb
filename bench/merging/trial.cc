#include "bench/merging/trial.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <mutex>
#include <numbers>
#include <utility>

#include "client/evaluation/trajectory_error.h"
#include "client/simulation/overlap.h"
#include "core/codec/payload_builder.h"
#include "server/pipeline.h"
#include "storage/memory_store.h"

namespace isthmus::bench {
namespace {

constexpr std::array kNames = {"robot_a", "robot_b"};
constexpr int kOverlapStride = 5;  // Scans that count for the overlap.
constexpr double kNearM = 20;      // Poses farther apart than this do not see the same.
constexpr double kRightM = 0.3, kRightDeg = 1.0;
constexpr double kDegrees = 180 / std::numbers::pi;

using PosePairs = std::vector<std::pair<Pose, Pose>>;  // Truth and estimate, scan by scan.

absl::Status Drive(const Pair& pair, int robot, server::Pipeline& pipeline,
                   simulation::SeenSurface* seen, Trial* trial) {
  const auto session = pipeline.CreateSession({RobotId(kNames[robot]), "vlp16"});
  if (!session.ok()) return session.status();
  const SessionId id = session->record.id;
  auto lost = std::make_shared<std::pair<std::mutex, int>>();
  absl::Status status = pipeline.SetAckSink(id, [lost](const ScanAck& ack) {
    std::lock_guard lock(lost->first);
    if (ack.status == "lost") ++lost->second;
  });
  for (int k = 0; status.ok() && k < pair.scan_count(); ++k) {
    const Scan scan = pair.MakeScan(robot, k);
    if (k % kOverlapStride == 0) seen->Add(scan, pair.Truth(robot, k));
    status = pipeline.SubmitScan(id, {scan.sequence, scan.end_stamp_ns, codec::MakePayload(scan)});
  }
  if (status.ok()) status = pipeline.FinishSession(id).status();
  std::lock_guard lock(lost->first);
  trial->lost_scans += lost->second;
  return status;
}

// Poses of lost scans are missing from the trajectory: found by their stamps.
absl::StatusOr<PosePairs> Poses(const Pair& pair, int robot, server::Pipeline& pipeline) {
  const auto trajectory =
      pipeline.GetTrajectory(RobotId(kNames[robot]), server::TrajectoryFrame::kOdom);
  if (!trajectory.ok()) return trajectory.status();
  PosePairs poses;
  int k = 0;
  for (const StampedPose& pose : trajectory->poses) {
    while (k < pair.scan_count() && pair.Stamp(robot, k) < pose.stamp_ns) ++k;
    if (k < pair.scan_count()) poses.emplace_back(pair.Truth(robot, k), pose.pose);
  }
  return poses;
}

double OwnRmse(const PosePairs& poses) {
  Trajectory truth, estimate;
  for (size_t k = 0; k < poses.size(); ++k) {
    truth.push_back({static_cast<int64_t>(k), poses[k].first});
    estimate.push_back({static_cast<int64_t>(k), poses[k].second});
  }
  const auto errors = evaluation::CompareTrajectories({{"robot", truth, estimate}});
  return errors.ok() ? errors->all.rmse_m : std::numeric_limits<double>::quiet_NaN();
}

MapError CompareMaps(const PosePairs& a, const PosePairs& b, const Pose& T_a_b) {
  std::vector<double> metres, degrees;
  for (const auto& [T_world_b, T_odom_b] : b) {
    const std::pair<Pose, Pose>* nearest = nullptr;
    double least = kNearM;
    for (const auto& pose : a) {
      const double d = (pose.first.translation() - T_world_b.translation()).norm();
      if (d < least) {
        least = d;
        nearest = &pose;
      }
    }
    if (nearest == nullptr) continue;
    const Pose truth = nearest->first.Inverse() * T_world_b;
    const Pose error = truth.Inverse() * (nearest->second.Inverse() * T_a_b * T_odom_b);
    metres.push_back(error.translation().norm());
    degrees.push_back(RotationAngle(error) * kDegrees);
  }
  if (metres.empty()) return {};
  const auto middle = static_cast<std::ptrdiff_t>(metres.size() / 2);
  std::nth_element(metres.begin(), metres.begin() + middle, metres.end());
  std::nth_element(degrees.begin(), degrees.begin() + middle, degrees.end());
  return {metres[middle], degrees[middle], true};
}

void Judge(const Pair& pair, const PosePairs& a, const PosePairs& b, Trial* trial) {
  if (trial->match.state != MatchState::kAccepted) return;
  trial->outcome = TrialOutcome::kWrong;
  if (!pair.SameWorld()) return;
  const Pose T_a_b =
      a.front().second * a.front().first.Inverse() * b.front().first * b.front().second.Inverse();
  const Pose start = T_a_b.Inverse() * trial->match.T_a_b;
  trial->start_m = start.translation().norm();
  trial->start_deg = RotationAngle(start) * kDegrees;
  trial->map = CompareMaps(a, b, trial->match.T_a_b);
  // Robots that were never near each other have nothing but their start frames to be judged by.
  const double metres = trial->map.known ? trial->map.median_m : trial->start_m;
  const double degrees = trial->map.known ? trial->map.median_deg : trial->start_deg;
  if (metres < kRightM && degrees < kRightDeg) trial->outcome = TrialOutcome::kRight;
}

}  // namespace

absl::StatusOr<Trial> RunTrial(const Pair& pair, uint64_t seed,
                               const server::PipelineOptions& options) {
  const auto pipeline = server::Pipeline::Open(options, storage::MakeMemoryStore());
  if (!pipeline.ok()) return pipeline.status();
  Trial trial;
  trial.seed = seed;
  std::array<simulation::SeenSurface, 2> seen = {simulation::SeenSurface(pair.overlap_cell_m()),
                                                 simulation::SeenSurface(pair.overlap_cell_m())};
  std::array<PosePairs, 2> poses;
  for (int robot = 0; robot < 2; ++robot) {
    absl::Status status = Drive(pair, robot, **pipeline, &seen[robot], &trial);
    if (!status.ok()) return status;
    auto known = Poses(pair, robot, **pipeline);
    if (!known.ok()) return known.status();
    if (known->empty()) return absl::InternalError("a robot was lost from its first scan on");
    poses[robot] = *std::move(known);
    trial.odometry_m = std::max(trial.odometry_m, OwnRmse(poses[robot]));
  }
  if (pair.SameWorld()) trial.overlap = simulation::SeenSurface::Overlap(seen[0], seen[1]);
  (*pipeline)->WaitUntilIdle();
  const server::MatchGraphView graph = (*pipeline)->GetMatchGraph();
  if (!graph.matches.empty()) trial.match = graph.matches.front();
  Judge(pair, poses[0], poses[1], &trial);
  return trial;
}

}  // namespace isthmus::bench
