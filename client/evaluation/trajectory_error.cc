#include "client/evaluation/trajectory_error.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <numbers>
#include <utility>

#include "client/evaluation/association.h"

namespace isthmus::evaluation {
namespace {

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

// The positions' errors, metres, and the orientations', degrees.
struct Deviations {
  std::vector<double> m, deg;
};

ErrorStatistics Totals(const Deviations& deviations) {
  const Statistics m = Summarize(deviations.m);
  return {m.count, m.rmse, m.mean, m.median, m.std, m.min, m.max, Summarize(deviations.deg)};
}

}  // namespace

absl::StatusOr<TrajectoryErrors> CompareTrajectories(const std::vector<TrajectoryPair>& pairs,
                                                     Alignment alignment, double tolerance_s) {
  if (pairs.empty()) {
    return absl::InvalidArgumentError("no trajectories to compare; give a truth and an estimate");
  }
  std::vector<std::vector<PosePair>> robots;
  for (const TrajectoryPair& pair : pairs) {
    robots.push_back(Associate(pair.truth, pair.estimate, tolerance_s));
    if (robots.back().empty()) return NothingInCommon(pair, tolerance_s);
  }
  const auto T_truth_estimate = Align(robots, alignment);
  if (!T_truth_estimate.ok()) return T_truth_estimate.status();

  TrajectoryErrors errors;
  errors.T_truth_estimate = *T_truth_estimate;
  Deviations all;
  for (const auto& robot : robots) {
    Deviations own;
    for (const PosePair& pair : robot) {
      const Pose error = pair.truth.Inverse() * (*T_truth_estimate * pair.estimate);
      own.m.push_back(error.translation().norm());
      own.deg.push_back(RotationAngle(error) * 180 / std::numbers::pi);
    }
    errors.robots.push_back(Totals(own));
    all.m.insert(all.m.end(), own.m.begin(), own.m.end());
    all.deg.insert(all.deg.end(), own.deg.begin(), own.deg.end());
  }
  errors.all = Totals(all);
  return errors;
}

}  // namespace isthmus::evaluation
