#include "lab/bench/summary.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <numbers>

namespace isthmus::bench {
namespace {

constexpr double kDegrees = 180 / std::numbers::pi;

bool HasPose(const ScanRecord& scan) {
  return scan.outcome == ScanOutcome::kOk || scan.outcome == ScanOutcome::kDegenerate;
}

// The deviation of the estimated pose from the truth, in the world frame.
struct Deviation {
  Eigen::Vector3d translation;
  double heading_rad, tilt_rad;
};

Deviation Deviate(const ScanRecord& scan, const Pose& T_world_odom) {
  const Pose estimated = T_world_odom * scan.T_odom_sensor;
  const Eigen::AngleAxisd turned(estimated.rotation() * scan.T_world_sensor.rotation().conjugate());
  const Eigen::Vector3d rotation = turned.angle() * turned.axis();
  return {estimated.translation() - scan.T_world_sensor.translation(), std::abs(rotation.z()),
          rotation.head<2>().norm()};
}

Pose AlignFirst(const std::vector<ScanRecord>& scans) {
  const auto first = std::find_if(scans.begin(), scans.end(), HasPose);
  if (first == scans.end()) return Pose();
  return first->T_world_sensor * first->T_odom_sensor.Inverse();
}

Pose AlignRigidly(const std::vector<ScanRecord>& scans) {
  const auto count = std::count_if(scans.begin(), scans.end(), HasPose);
  if (count < 3) return AlignFirst(scans);
  Eigen::Matrix3Xd truth(3, count), estimated(3, count);
  Eigen::Index i = 0;
  for (const ScanRecord& scan : scans) {
    if (!HasPose(scan)) continue;
    truth.col(i) = scan.T_world_sensor.translation();
    estimated.col(i++) = scan.T_odom_sensor.translation();
  }
  return Pose::FromMatrix(Eigen::umeyama(estimated, truth, /*with_scaling=*/false));
}

// Segments share no frame: later ones in that of the first, where all of each fits the truth best.
std::vector<ScanRecord> InOneFrame(std::vector<ScanRecord> scans) {
  const auto first = std::find_if(scans.begin(), scans.end(), HasPose);
  if (first == scans.end()) return scans;
  std::map<uint32_t, std::vector<ScanRecord>> segments;
  for (const ScanRecord& scan : scans) segments[scan.segment].push_back(scan);
  const uint32_t first_segment = first->segment;
  const Pose T_first_world = AlignRigidly(segments[first_segment]).Inverse();
  std::map<uint32_t, Pose> T_first_odom;
  for (const auto& [segment, of] : segments) {
    T_first_odom[segment] = T_first_world * AlignRigidly(of);
  }
  for (ScanRecord& scan : scans) {
    if (scan.segment == first_segment) continue;
    scan.T_odom_sensor = T_first_odom[scan.segment] * scan.T_odom_sensor;
  }
  return scans;
}

// Root of the mean square, and the largest, of what is added.
struct Spread {
  double sum = 0, worst = 0;
  int count = 0;

  void Add(double value) {
    sum += value * value;
    worst = std::max(worst, std::abs(value));
    ++count;
  }
  double Rms() const { return count > 0 ? std::sqrt(sum / count) : 0; }
};

std::vector<double> Costs(const std::vector<ScanRecord>& scans, double ScanRecord::*cost,
                          size_t begin, size_t end) {
  std::vector<double> values;
  for (size_t i = begin; i < std::min(end, scans.size()); ++i) {
    if (scans[i].outcome != ScanOutcome::kRejected) values.push_back(scans[i].*cost);
  }
  return values;
}

std::optional<double> LostRatio(const std::vector<ScanRecord>& scans) {
  constexpr int kSome = 10;
  double lost_ms = 0, other_ms = 0;
  int lost = 0, others = 0;
  for (const ScanRecord& scan : scans) {
    if (scan.outcome == ScanOutcome::kRejected) continue;
    const bool is_lost = scan.outcome == ScanOutcome::kLost;
    (is_lost ? lost_ms : other_ms) += scan.ms;
    ++(is_lost ? lost : others);
  }
  if (lost < kSome || others < kSome) return std::nullopt;
  return lost_ms / lost / (other_ms / others);
}

CostSummary SummarizeCost(const std::vector<ScanRecord>& scans) {
  const auto median = [&](double ScanRecord::*cost, size_t begin, size_t end) {
    return Percentile(Costs(scans, cost, begin, end), 0.5);
  };
  CostSummary cost;
  const size_t count = scans.size();
  cost.median_ms = median(&ScanRecord::ms, 0, count);
  cost.p99_ms = Percentile(Costs(scans, &ScanRecord::ms, 0, count), 0.99);
  cost.max_ms = Percentile(Costs(scans, &ScanRecord::ms, 0, count), 1);
  cost.features_ms = median(&ScanRecord::features_ms, 0, count);
  cost.matching_ms = median(&ScanRecord::matching_ms, 0, count);
  cost.map_ms = median(&ScanRecord::map_ms, 0, count);
  if (count >= 400) {
    cost.early_ms = median(&ScanRecord::ms, 200, 300);
    cost.late_ms = median(&ScanRecord::ms, count - 100, count);
  }
  cost.lost_ratio = LostRatio(scans);
  return cost;
}

ErrorSummary SummarizeErrors(const std::vector<ScanRecord>& scans, const Pose& first,
                             const Pose& rigid) {
  ErrorSummary error;
  Spread rigidly, from_first, heading, tilt;
  for (const ScanRecord& scan : scans) {
    if (!HasPose(scan)) continue;
    const Deviation deviation = Deviate(scan, first);
    error.last_m = Deviate(scan, rigid).translation.norm();
    rigidly.Add(error.last_m);
    from_first.Add(deviation.translation.norm());
    heading.Add(deviation.heading_rad * kDegrees);
    tilt.Add(deviation.tilt_rad * kDegrees);
    error.final_m = deviation.translation.norm();
  }
  error.rmse_m = rigidly.Rms();
  error.worst_m = rigidly.worst;
  error.first_rmse_m = from_first.Rms();
  error.first_worst_m = from_first.worst;
  error.heading_rmse_deg = heading.Rms();
  error.heading_worst_deg = heading.worst;
  error.tilt_rmse_deg = tilt.Rms();
  error.tilt_worst_deg = tilt.worst;
  return error;
}

CountSummary Count(const Drive& drive, const std::vector<ScanRecord>& scans, const Pose& first,
                   const Pose& rigid) {
  CountSummary counts;
  for (size_t i = 0; i < scans.size(); ++i) {
    const ScanRecord& scan = scans[i];
    counts.segments = std::max(counts.segments, static_cast<int>(scan.segment));
    counts.degenerate += scan.outcome == ScanOutcome::kDegenerate;
    counts.lost += scan.outcome == ScanOutcome::kLost;
    counts.rejected += scan.outcome == ScanOutcome::kRejected;
    if (scan.outcome != ScanOutcome::kOk) continue;
    ++counts.ok;
    counts.covered_ok += drive.shots[i].view != View::kWhole;
    counts.silent += Deviate(scan, first).translation.norm() > drive.wrong_m &&
                     Deviate(scan, rigid).translation.norm() > drive.wrong_m;
  }
  return counts;
}

int ScansToRecover(const Drive& drive, const std::vector<ScanRecord>& scans, const Pose& first) {
  for (size_t i = drive.trouble_ends; i < scans.size(); ++i) {
    if (HasPose(scans[i]) && Deviate(scans[i], first).translation.norm() <= drive.wrong_m) {
      return static_cast<int>(i) - drive.trouble_ends;
    }
  }
  return -1;
}

CorridorSummary SummarizeCorridor(const std::vector<ScanRecord>& scans, const Pose& first) {
  constexpr double kBegins = 12, kEnds = 78;  // Its doors are at 10 and 80.
  constexpr double kAlong = 0.94;             // Cosine of 20 degrees.
  Spread along, across, height, heading;
  int flagged = 0;
  for (const ScanRecord& scan : scans) {
    const double x = scan.T_world_sensor.translation().x();
    if (!HasPose(scan) || x < kBegins || x > kEnds) continue;
    const Deviation deviation = Deviate(scan, first);
    along.Add(deviation.translation.x());
    across.Add(deviation.translation.y());
    height.Add(deviation.translation.z());
    heading.Add(deviation.heading_rad * kDegrees);
    flagged += std::any_of(scan.unobserved.begin(), scan.unobserved.end(), [&](const auto& d) {
      return std::abs((scan.T_world_sensor.rotation() * d).x()) > kAlong;
    });
  }
  return {along.worst, across.worst, height.worst, heading.worst,
          along.count > 0 ? static_cast<double>(flagged) / along.count : 0};
}

LapSummary SummarizeLap(const std::vector<ScanRecord>& scans, size_t begin, size_t end,
                        const Pose& first) {
  LapSummary lap;
  Spread error;
  for (size_t i = begin; i < end; ++i) {
    if (HasPose(scans[i])) error.Add(Deviate(scans[i], first).translation.norm());
    if (scans[i].heap_mb > 0) lap.odometry_mb = scans[i].heap_mb;
  }
  lap.median_ms = Percentile(Costs(scans, &ScanRecord::ms, begin, end), 0.5);
  lap.rmse_m = error.Rms();
  return lap;
}

}  // namespace

double Percentile(std::vector<double> values, double share) {
  if (values.empty()) return 0;
  const auto rank = static_cast<size_t>(std::ceil(share * static_cast<double>(values.size())));
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(std::max<size_t>(rank, 1) - 1);
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

Summary Summarize(const Drive& drive, const RunRecord& run, bool is_corridor) {
  const std::vector<ScanRecord> scans = InOneFrame(run.scans);
  const Pose first = AlignFirst(scans), rigid = AlignRigidly(scans);
  Summary summary;
  summary.cost = SummarizeCost(scans);
  summary.error = SummarizeErrors(scans, first, rigid);
  summary.counts = Count(drive, scans, first, rigid);
  summary.cal_ms = run.cal_ms;
  summary.odometry_mb = run.odometry_mb;
  summary.peak_mb = run.peak_mb;
  if (drive.trouble_ends >= 0) {
    summary.scans_to_recover = ScansToRecover(drive, scans, first);
  }
  if (is_corridor) summary.corridor = SummarizeCorridor(scans, first);
  if (drive.lap_shots > 0) {
    const auto length = static_cast<size_t>(drive.lap_shots);
    for (size_t i = drive.lap_begins; i + length <= scans.size(); i += length) {
      summary.laps.push_back(SummarizeLap(scans, i, i + length, first));
    }
  }
  return summary;
}

}  // namespace isthmus::bench
