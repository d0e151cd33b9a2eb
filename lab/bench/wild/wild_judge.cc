#include "lab/bench/wild/wild_judge.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>

#include "core/geometry/angles.h"
#include "lab/bench/summary.h"

namespace isthmus::bench {
namespace {

bool IsLost(const ScanRecord& scan) {
  return scan.outcome == ScanOutcome::kLost || scan.outcome == ScanOutcome::kRejected;
}

void CountLost(const std::vector<ScanRecord>& scans, double period_s, WildScore* score) {
  int in_long = 0;
  for (size_t begin = 0; begin < scans.size();) {
    size_t end = begin;
    while (end < scans.size() && IsLost(scans[end])) ++end;
    const double seconds = static_cast<double>(end - begin) * period_s;
    score->longest_lost_s = std::max(score->longest_lost_s, seconds);
    if (seconds > kLongLostS) in_long += static_cast<int>(end - begin);
    begin = end + 1;
  }
  if (!scans.empty()) score->lost_long = in_long / static_cast<double>(scans.size());
}

int CountLostThoughRight(const std::vector<ScanRecord>& scans) {
  constexpr double kMetres = 0.05, kDegrees = 1;
  const ScanRecord* known = nullptr;
  int count = 0;
  for (const ScanRecord& scan : scans) {
    if (!IsLost(scan)) known = &scan;
    if (scan.outcome != ScanOutcome::kLost || known == nullptr || known->segment != scan.segment) {
      continue;
    }
    const Pose truth = known->T_world_sensor.Inverse() * scan.T_world_sensor;
    const Pose error = truth.Inverse() * (known->T_odom_sensor.Inverse() * scan.T_odom_sensor);
    count += error.translation().norm() <= kMetres && RotationAngle(error) <= kDegrees * kRadPerDeg;
  }
  return count;
}

// Squares of the errors of one segment's scans, each aligned with the truth by all.
std::vector<double> SquaredErrors(const std::vector<const ScanRecord*>& scans) {
  const auto count = static_cast<Eigen::Index>(scans.size());
  Eigen::Matrix3Xd truth(3, count), estimated(3, count);
  for (Eigen::Index i = 0; i < count; ++i) {
    truth.col(i) = scans[i]->T_world_sensor.translation();
    estimated.col(i) = scans[i]->T_odom_sensor.translation();
  }
  if (count >= 3) {
    const Eigen::Matrix4d T = Eigen::umeyama(estimated, truth, /*with_scaling=*/false);
    estimated = (T.topLeftCorner<3, 3>() * estimated).colwise() + T.topRightCorner<3, 1>();
  } else {
    estimated = truth;  // Fits whatever it is.
  }
  const Eigen::VectorXd squares = (estimated - truth).colwise().squaredNorm();
  return {squares.begin(), squares.end()};
}

using Segments = std::map<uint32_t, std::vector<const ScanRecord*>>;

struct Errors {
  double rmse_m = 0, worst_m = 0;
};

Errors ErrorsOf(const Segments& segments) {
  Errors errors;
  double sum = 0, count = 0;
  for (const auto& [segment, scans] : segments) {
    for (const double square : SquaredErrors(scans)) {
      sum += square;
      ++count;
      errors.worst_m = std::max(errors.worst_m, std::sqrt(square));
    }
  }
  if (count > 0) errors.rmse_m = std::sqrt(sum / count);
  return errors;
}

// The error of the motion from one scan to another, seen from either of them: a scan whose
// orientation alone is a little off is not off by that angle times the way.
double RelativeError(const ScanRecord& from, const ScanRecord& to) {
  const auto seen_from = [](const ScanRecord& a, const ScanRecord& b) {
    const Pose truth = a.T_world_sensor.Inverse() * b.T_world_sensor;
    const Pose estimated = a.T_odom_sensor.Inverse() * b.T_odom_sensor;
    return (truth.translation() - estimated.translation()).norm();
  };
  return std::min(seen_from(from, to), seen_from(to, from));
}

void CountSilent(const std::vector<ScanRecord>& scans, const std::vector<double>& path_length,
                 WildScore* score) {
  constexpr double kStretchM = 10, kAllowedM = 0.3, kAllowedShare = 0.01;
  std::map<uint32_t, std::vector<size_t>> ok;  // By segment, in order.
  std::vector<int> told(scans.size() + 1, 0);  // Degenerate scans before each.
  for (size_t i = 0; i < scans.size(); ++i) {
    told[i + 1] = told[i] + (scans[i].outcome == ScanOutcome::kDegenerate);
    if (scans[i].outcome != ScanOutcome::kOk) continue;
    std::vector<size_t>& before = ok[scans[i].segment];
    // The latest that is so far back, else the first.
    const auto later = std::partition_point(before.begin(), before.end(), [&](size_t k) {
      return path_length[i] - path_length[k] >= kStretchM;
    });
    const bool is_first = before.empty();
    const size_t from = is_first ? i : later == before.begin() ? before.front() : *(later - 1);
    before.push_back(i);
    if (is_first) continue;
    const double allowed = kAllowedM + kAllowedShare * (path_length[i] - path_length[from]);
    if (RelativeError(scans[from], scans[i]) <= allowed) continue;
    ++score->silent;
    score->silent_untold += told[i] == told[from];
  }
}

}  // namespace

WildScore ScoreWildDrive(const std::vector<ScanRecord>& scans, double period_s) {
  WildScore score;
  score.scans = static_cast<int>(scans.size());
  Segments segments, posed;
  std::vector<double> path_length, costs;
  for (size_t i = 0; i < scans.size(); ++i) {
    const ScanRecord& scan = scans[i];
    const Eigen::Vector3d& at = scan.T_world_sensor.translation();
    path_length.push_back(
        i == 0 ? 0 : path_length.back() + (at - scans[i - 1].T_world_sensor.translation()).norm());
    score.ok += scan.outcome == ScanOutcome::kOk;
    score.degenerate += scan.outcome == ScanOutcome::kDegenerate;
    score.lost += scan.outcome == ScanOutcome::kLost;
    score.rejected += scan.outcome == ScanOutcome::kRejected;
    if (!IsLost(scan)) posed[scan.segment].push_back(&scan);
    if (scan.outcome == ScanOutcome::kOk) segments[scan.segment].push_back(&scan);
    if (scan.outcome != ScanOutcome::kRejected) costs.push_back(scan.ms);
  }
  score.segments = static_cast<int>(segments.size());
  if (!path_length.empty()) score.path_length_m = path_length.back();
  score.median_ms = Percentile(costs, 0.5);
  CountLost(scans, period_s, &score);
  score.lost_though_right = CountLostThoughRight(scans);
  // Standing still is no way: errors count as if of one metre.
  const double percent = 100 / std::max(score.path_length_m, 1.0);
  const Errors errors = ErrorsOf(segments);
  score.rmse_m = errors.rmse_m;
  score.worst_m = errors.worst_m;
  score.rmse_percent = percent * errors.rmse_m;
  score.posed_percent = percent * ErrorsOf(posed).rmse_m;
  CountSilent(scans, path_length, &score);
  return score;
}

}  // namespace isthmus::bench
