#include "client/evaluation/trajectory_error.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <utility>

namespace isthmus::evaluation {
namespace {

struct PosePair {
  Pose truth, estimate;
};

// The pairs of poses of equal time, in order of time.
std::vector<PosePair> Associate(const TrajectoryPair& pair, double tolerance_s) {
  const auto by_stamp = [](const StampedPose& a, const StampedPose& b) {
    return a.stamp_ns < b.stamp_ns;
  };
  Trajectory truth = pair.truth, estimate = pair.estimate;
  std::stable_sort(truth.begin(), truth.end(), by_stamp);
  std::stable_sort(estimate.begin(), estimate.end(), by_stamp);
  std::vector<PosePair> associated;
  for (const StampedPose& entry : estimate) {
    auto nearest = std::lower_bound(truth.begin(), truth.end(), entry, by_stamp);
    const auto distance = [&](auto it) {
      return std::abs(static_cast<double>(it->stamp_ns - entry.stamp_ns)) * 1e-9;
    };
    if (nearest != truth.begin() &&
        (nearest == truth.end() || distance(std::prev(nearest)) <= distance(nearest))) {
      --nearest;
    }
    if (nearest == truth.end() || distance(nearest) > tolerance_s) continue;
    associated.push_back({nearest->pose, entry.pose});
  }
  return associated;
}

std::string Span(const Trajectory& trajectory) {
  if (trajectory.empty()) return "empty";
  const auto [first, last] = std::minmax_element(
      trajectory.begin(), trajectory.end(),
      [](const StampedPose& a, const StampedPose& b) { return a.stamp_ns < b.stamp_ns; });
  return absl::StrFormat("%.3f to %.3f s", static_cast<double>(first->stamp_ns) * 1e-9,
                         static_cast<double>(last->stamp_ns) * 1e-9);
}

absl::Status NothingInCommon(const TrajectoryPair& pair, double tolerance_s) {
  return absl::InvalidArgumentError(absl::StrFormat(
      "%s: no estimated pose has a true one within %g s (truth: %s; estimate: %s); check that both "
      "files are of the same run and that their stamps count from the same instant",
      pair.name.empty() ? "trajectory" : pair.name, tolerance_s, Span(pair.truth),
      Span(pair.estimate)));
}

absl::StatusOr<Pose> Align(const std::vector<std::vector<PosePair>>& robots, Alignment alignment) {
  if (alignment == Alignment::kNone) return Pose();
  if (alignment == Alignment::kFirstPose) {
    return robots[0][0].truth * robots[0][0].estimate.Inverse();
  }
  size_t count = 0;
  for (const auto& robot : robots) count += robot.size();
  if (count < 3) {
    return absl::InvalidArgumentError(
        absl::StrCat("a rigid alignment needs 3 poses or more, but only ", count,
                     " have a stamp in common; align by the first pose instead"));
  }
  Eigen::Matrix3Xd truth(3, count), estimate(3, count);
  Eigen::Index i = 0;
  for (const auto& robot : robots) {
    for (const PosePair& pair : robot) {
      truth.col(i) = pair.truth.translation();
      estimate.col(i++) = pair.estimate.translation();
    }
  }
  return Pose::FromMatrix(Eigen::umeyama(estimate, truth, /*with_scaling=*/false));
}

struct Deviation {
  double distance_m, angle_rad;
};

ErrorStatistics Summarize(const std::vector<Deviation>& deviations) {
  ErrorStatistics statistics;
  statistics.count = deviations.size();
  const auto count = static_cast<double>(deviations.size());
  std::vector<double> distances;
  double angles = 0;
  for (const Deviation& d : deviations) {
    distances.push_back(d.distance_m);
    statistics.mean_m += d.distance_m / count;
    statistics.rmse_m += d.distance_m * d.distance_m / count;
    angles += d.angle_rad * d.angle_rad / count;
  }
  statistics.rmse_m = std::sqrt(statistics.rmse_m);
  statistics.rotation_rmse_deg = std::sqrt(angles) * 180 / std::numbers::pi;
  std::sort(distances.begin(), distances.end());
  const size_t half = distances.size() / 2;
  statistics.median_m =
      distances.size() % 2 == 1 ? distances[half] : (distances[half - 1] + distances[half]) / 2;
  statistics.max_m = distances.back();
  return statistics;
}

}  // namespace

absl::StatusOr<TrajectoryErrors> CompareTrajectories(const std::vector<TrajectoryPair>& pairs,
                                                     Alignment alignment, double tolerance_s) {
  if (pairs.empty()) {
    return absl::InvalidArgumentError("no trajectories to compare; give a truth and an estimate");
  }
  std::vector<std::vector<PosePair>> robots;
  for (const TrajectoryPair& pair : pairs) {
    robots.push_back(Associate(pair, tolerance_s));
    if (robots.back().empty()) return NothingInCommon(pair, tolerance_s);
  }
  const auto T_truth_estimate = Align(robots, alignment);
  if (!T_truth_estimate.ok()) return T_truth_estimate.status();

  TrajectoryErrors errors;
  errors.T_truth_estimate = *T_truth_estimate;
  std::vector<Deviation> all;
  for (const auto& robot : robots) {
    std::vector<Deviation> deviations;
    for (const PosePair& pair : robot) {
      const Pose error = pair.truth.Inverse() * (*T_truth_estimate * pair.estimate);
      deviations.push_back({error.translation().norm(), RotationAngle(error)});
    }
    errors.robots.push_back(Summarize(deviations));
    all.insert(all.end(), deviations.begin(), deviations.end());
  }
  errors.all = Summarize(all);
  return errors;
}

}  // namespace isthmus::evaluation
