#include "lab/bench/merging/asked_trial.h"

#include <absl/strings/str_cat.h>

#include <array>
#include <numbers>
#include <utility>

#include "lab/bench/merging/odom_frames.h"
#include "lab/bench/merging/seen_surface.h"
#include "lab/bench/merging/trial.h"

namespace isthmus::bench {
namespace {

constexpr double kLeastOverlap = 0.02;  // Below there is nothing to be found.
constexpr double kElsewhereM = 1, kElsewhereRad = 3 * std::numbers::pi / 180;

// One robot of the pair.
struct Rider {
  DriveOptions drive;
  ScanRange kept;
  DrivenRobot robot;  // With these scans only.
};

using Riders = std::array<Rider, 2>;

absl::StatusOr<DrivenRobot> Ride(const DriveOptions& drive, const ScanRange& kept,
                                 DriveCache& cache) {
  auto robot = cache.Get(drive);
  if (robot.ok()) KeepScans(kept, &*robot);
  return robot;
}

absl::StatusOr<Riders> SetOut(const WildPair& pair, DriveCache& cache) {
  auto whole = WholeRobots(pair, cache);
  if (!whole.ok()) return whole.status();
  const auto [of_a, of_b] = KeptScans(pair, *whole);
  Riders riders = {Rider{pair.a, of_a, std::move((*whole)[0])},
                   Rider{pair.b, of_b, std::move((*whole)[1])}};
  for (Rider& rider : riders) KeepScans(rider.kept, &rider.robot);
  return riders;
}

// The server's judgement by the truth.
absl::StatusOr<PairResult> Judge(const DrivenRobot& a, const DrivenRobot& b, uint64_t seed,
                                 const server::PipelineOptions& options) {
  std::vector<DrivenRobot> robots = {a, b};
  MoveOdom(RandomFrame(seed, 1), &robots[1]);
  auto trial = RunTrial(std::move(robots), options, {});
  if (!trial.ok()) return trial.status();
  return std::move(trial->pairs[0]);
}

// Both have a hypothesis, and the map of b lies elsewhere by it. `at` is in b's odom frame.
bool IsElsewhere(const PairResult& before, const PairResult& now, const Eigen::Vector3d& at) {
  if (!before.HasHypothesis()) return false;
  if (!now.HasHypothesis()) return true;
  const Pose &old = before.match.T_a_b, &other = now.match.T_a_b;
  return (old * at - other * at).norm() > kElsewhereM ||
         RotationAngle(old.Inverse() * other) > kElsewhereRad;
}

AskedState StateOf(const PairResult& before, const PairResult& now, const Eigen::Vector3d& at) {
  AskedState state{AskedOutcome::kWaiting, now.match.state, now.match.reason, now.match.confidence,
                   now.hypothesis_right && now.HasHypothesis()};
  if (now.outcome == TrialOutcome::kRight) {
    state.outcome = AskedOutcome::kRight;
  } else if (now.outcome == TrialOutcome::kWrong) {
    state.outcome = AskedOutcome::kWrong;
  } else if (!before.hypothesis_right && IsElsewhere(before, now, at)) {
    state.outcome = AskedOutcome::kRefuted;
  }
  return state;
}

std::vector<Eigen::Vector3d> InWorld(const DrivenRobot& robot, const std::vector<WayPoint>& way) {
  std::vector<Eigen::Vector3d> points;
  for (const WayPoint& point : way) {
    if (point.submap >= robot.submaps.size()) continue;
    const ScanPose* at = robot.FindPose(robot.submaps[point.submap]->keyframes[0].sequence);
    if (at != nullptr) points.push_back(at->T_world_sensor * point.position);
  }
  return points;
}

// The one drive is the beginning of the other. False where the odometry began anew, so that the
// beginning is gone.
absl::StatusOr<bool> Continues(const DrivenRobot& before, const DrivenRobot& now) {
  for (const ScanPose& pose : before.poses) {
    const ScanPose* same = now.FindPose(pose.sequence);
    if (same == nullptr) return false;
    if (same->T_world_sensor.Matrix() != pose.T_world_sensor.Matrix() ||
        same->T_odom_sensor.Matrix() != pose.T_odom_sensor.Matrix()) {
      return absl::InternalError(
          absl::StrCat("scan ", pose.sequence, " of a longer drive is not where it was"));
    }
  }
  return true;
}

// The scan that comes so many metres after `sequence`, and the metres that are missing if the drive
// ends before.
std::pair<uint64_t, double> ScanAfter(const DrivenRobot& robot, uint64_t sequence, double metres) {
  constexpr double kStride = 0.5;  // Swaying is no way.
  const ScanPose* last = nullptr;
  for (const ScanPose& pose : robot.poses) {
    if (pose.sequence < sequence) continue;
    if (last == nullptr) last = &pose;
    const Eigen::Vector3d by =
        pose.T_world_sensor.translation() - last->T_world_sensor.translation();
    if (by.head<2>().norm() < kStride) continue;
    metres -= by.head<2>().norm();
    last = &pose;
    if (metres <= 0) return {pose.sequence, 0};
  }
  return {UINT64_MAX, metres};
}

// The robot as it drives on by itself, `metres` at least after what was kept.
absl::StatusOr<DrivenRobot> Wander(const Rider& rider, double metres, DriveCache& cache) {
  auto robot = cache.Get(rider.drive);
  if (!robot.ok()) return robot;
  const double missing = ScanAfter(*robot, rider.robot.poses.back().sequence, metres).second;
  if (missing <= 0) return robot;
  DriveOptions longer = rider.drive;
  constexpr double kSpare = 2;  // Metres of turning round.
  longer.further = {
      {.after_scans = static_cast<int>(robot->poses.back().sequence), .along_m = missing + kSpare}};
  return cache.Get(longer);
}

// The part of it that ends so many metres after what was kept.
DrivenRobot Part(const DrivenRobot& whole, const Rider& rider, double metres) {
  DrivenRobot part = whole;
  KeepScans({rider.kept.first, ScanAfter(whole, rider.robot.poses.back().sequence, metres).first},
            &part);
  return part;
}

// Fills AskedStep::wandering. `riders` are as they were before any drive.
absl::Status RunWandering(const Riders& riders, const PairResult& before, uint64_t seed,
                          const server::PipelineOptions& options, DriveCache& cache,
                          const Eigen::Vector3d& at, std::vector<AskedStep>* steps) {
  std::array<double, 2> metres = {};
  for (const AskedStep& step : *steps) metres[step.robot] += step.metres;
  std::array<DrivenRobot, 2> wanderers;
  bool lost = false;
  for (size_t i = 0; i < riders.size(); ++i) {
    auto wanderer = Wander(riders[i], metres[i], cache);
    if (!wanderer.ok()) return wanderer.status();
    const auto continues = Continues(riders[i].robot, *wanderer);
    if (!continues.ok()) return continues.status();
    lost = lost || !*continues;
    wanderers[i] = *std::move(wanderer);
  }
  metres = {};
  for (AskedStep& step : *steps) {
    metres[step.robot] += step.metres;
    if (lost) {
      step.wandering.outcome = AskedOutcome::kLost;
      continue;
    }
    std::array<DrivenRobot, 2> parts;
    for (size_t i = 0; i < riders.size(); ++i) {
      parts[i] = metres[i] > 0 ? Part(wanderers[i], riders[i], metres[i]) : riders[i].robot;
    }
    const auto now = Judge(parts[0], parts[1], seed, options);
    if (!now.ok()) return now.status();
    step.wandering = StateOf(before, *now, at);
  }
  return absl::OkStatus();
}

}  // namespace

bool AskedTrial::Waits() const {
  return before.outcome == AskedOutcome::kWaiting && overlap >= kLeastOverlap;
}

absl::StatusOr<AskedTrial> RunAskedTrial(const WildPair& pair, uint64_t seed,
                                         const server::PipelineOptions& options, DriveCache& cache,
                                         const Asker& asker) {
  const auto set_out = SetOut(pair, cache);
  if (!set_out.ok()) return set_out.status();
  Riders riders = *set_out;
  const auto before = Judge(riders[0].robot, riders[1].robot, seed, options);
  if (!before.ok()) return before.status();
  // Hypotheses are told apart where the second robot was in the middle of its drive.
  const auto& submaps = riders[1].robot.submaps;
  const Eigen::Vector3d at =
      RandomFrame(seed, 1) * submaps[submaps.size() / 2]->T_odom_submap.translation();
  AskedTrial trial{NameOf(pair),
                   pair.seed,
                   pair.a.robot,
                   pair.b.robot,
                   before->overlap,
                   StateOf(*before, *before, at),
                   {}};
  PairResult now = *before;
  for (int i = 0; i < kAskedDrives && trial.Waits(); ++i) {
    if (now.outcome != TrialOutcome::kNotMerged) break;
    const std::vector<AskedDrive> asked = asker(now.match, {riders[0].robot, riders[1].robot});
    if (asked.empty()) break;
    const AskedDrive& drive = asked.front();
    Rider& rider = riders[drive.by_b ? 1 : 0];
    const std::vector<Eigen::Vector3d> way = InWorld(rider.robot, drive.way);
    if (way.empty()) return absl::InternalError("a drive is asked for by points of no submap");
    rider.drive.further.push_back(
        {.after_scans = static_cast<int>(rider.robot.poses.back().sequence), .way = way});
    rider.kept.last = UINT64_MAX;
    auto longer = Ride(rider.drive, rider.kept, cache);
    if (!longer.ok()) return longer.status();
    const auto continues = Continues(rider.robot, *longer);
    if (!continues.ok()) return continues.status();
    const bool right =
        drive.rival == 0 ? now.hypothesis_right : now.rivals_right.at(drive.rival - 1);
    AskedStep& step = trial.steps.emplace_back(AskedStep{drive.by_b ? 1 : 0,
                                                         drive.length_m,
                                                         longer->further_m,
                                                         longer->blocked,
                                                         drive.confidence,
                                                         right,
                                                         {},
                                                         {}});
    step.asked.outcome = AskedOutcome::kLost;
    if (!*continues) break;
    rider.robot = *std::move(longer);
    auto judged = Judge(riders[0].robot, riders[1].robot, seed, options);
    if (!judged.ok()) return judged.status();
    now = *std::move(judged);
    step.asked = StateOf(*before, now, at);
  }
  if (trial.steps.empty()) return trial;
  absl::Status status = RunWandering(*set_out, *before, seed, options, cache, at, &trial.steps);
  if (!status.ok()) return status;
  return trial;
}

}  // namespace isthmus::bench
