#include "floam/ring_scan.h"

#include <absl/strings/str_cat.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "floam/azimuth.h"
#include "floam/ring_inference.h"

namespace isthmus::floam {
namespace {

constexpr float kTurn = 2 * std::numbers::pi_v<float>;
constexpr size_t kMinPoints = 100;
constexpr float kMinExtentM = 0.2F;  // All points within a box this small: nothing was seen.
constexpr int kMaxRings = 1024;
constexpr double kMinRingMajorTurns = 3.5;
constexpr double kMaxRingMisfit = 0.2;  // See RingsByElevation.
constexpr float kMaxScanS = 2;
constexpr float kClockSlackS = 1e-3F;

bool InRange(const ScanPoint& p, const SensorModel& model) {
  const float range2 = p.x * p.x + p.y * p.y + p.z * p.z;
  return range2 >= static_cast<float>(model.min_range_m * model.min_range_m) &&
         range2 <= static_cast<float>(model.max_range_m * model.max_range_m);
}

}  // namespace

absl::Status RingSorter::Sort(const Scan& scan, const SensorModel& model, double period_s,
                              RingScan* out) {
  if (absl::Status status = Validate(scan, model); !status.ok()) return status;
  out->period_s = period_s;
  if (!scan.has_ring || !scan.has_time) ComputeAngles(scan);
  AssignRings(scan, model, out);
  AssignTimes(scan, model, out);
  Scatter(scan, model, out);
  return absl::OkStatus();
}

absl::Status RingSorter::Validate(const Scan& scan, const SensorModel& model) {
  Eigen::Array3f low = Eigen::Array3f::Constant(1e9F), high = -low;
  size_t usable = 0;
  float earliest = 0, latest = 0;
  int top_ring = 0;
  // Sums of 0 * x are NaN as soon as one x is not finite: one test at the end instead of one per
  // value.
  float poison = 0;
  for (const ScanPoint& p : scan.points) {
    poison += 0 * (p.x + p.y + p.z) + 0 * p.time;
    earliest = std::min(earliest, p.time);
    latest = std::max(latest, p.time);
    top_ring = std::max<int>(top_ring, p.ring);
    if (!InRange(p, model)) continue;
    const Eigen::Array3f position(p.x, p.y, p.z);
    low = low.min(position);
    high = high.max(position);
    ++usable;
  }
  if (!std::isfinite(poison)) {
    return absl::InvalidArgumentError(absl::StrCat(
        "scan ", scan.sequence, " has coordinates or times that are not finite; drop such points"));
  }
  if (usable < kMinPoints) {
    return absl::InvalidArgumentError(absl::StrCat("scan ", scan.sequence, " has ", usable, " of ",
                                                   scan.points.size(), " points between ",
                                                   model.min_range_m, " m and ", model.max_range_m,
                                                   " m; at least ", kMinPoints, " are needed"));
  }
  if ((high - low).maxCoeff() < kMinExtentM) {
    return absl::InvalidArgumentError(
        absl::StrCat("all points of scan ", scan.sequence, " are in one place"));
  }
  if (scan.has_time && (earliest < -kMaxScanS || latest > kClockSlackS)) {
    return absl::InvalidArgumentError(absl::StrCat(
        "scan ", scan.sequence, " has point times from ", earliest, " s to ", latest,
        " s; they must be relative to the END of the scan, within the last ", kMaxScanS, " s"));
  }
  if (scan.has_ring && top_ring >= kMaxRings) {
    return absl::InvalidArgumentError(absl::StrCat("scan ", scan.sequence, " names ring ", top_ring,
                                                   "; at most ", kMaxRings, " are supported"));
  }
  return absl::OkStatus();
}

void RingSorter::ComputeAngles(const Scan& scan) {
  azimuths_.resize(scan.points.size());
  for (size_t i = 0; i < scan.points.size(); ++i) {
    azimuths_[i] = FastAtan2(scan.points[i].y, scan.points[i].x);
  }
  double travelled = 0;
  for (size_t i = 1; i < azimuths_.size(); ++i) {
    travelled += WrapOnce(azimuths_[i] - azimuths_[i - 1]);
  }
  turns_ = travelled / kTurn;
}

void RingSorter::AssignRings(const Scan& scan, const SensorModel& model, RingScan* out) {
  if (scan.has_ring) {
    out->rings_from = Inference::kSensor;
    int top = 0;
    rings_.resize(scan.points.size());
    for (size_t i = 0; i < scan.points.size(); ++i) {
      rings_[i] = scan.points[i].ring;
      top = std::max<int>(top, rings_[i]);
    }
    ring_count_ = top + 1;
    return;
  }
  if (std::abs(turns_) >= kMinRingMajorTurns) {
    out->rings_from = Inference::kPointOrder;
    ring_count_ = RingsByWrap(azimuths_, turns_, &rings_);
    return;
  }
  if (!model.elevations.empty() &&
      RingsByElevation(scan, model.elevations, &rings_) < kMaxRingMisfit) {
    out->rings_from = Inference::kSensorModel;
    ring_count_ = static_cast<int>(model.elevations.size());
    return;
  }
  std::vector<double> elevations = FindElevations(scan);
  if (elevations.empty()) elevations = model.elevations;
  if (elevations.empty()) elevations = {0};
  RingsByElevation(scan, elevations, &rings_);
  out->rings_from = Inference::kHistogram;
  ring_count_ = static_cast<int>(elevations.size());
}

void RingSorter::AssignTimes(const Scan& scan, const SensorModel& model, RingScan* out) {
  times_.resize(scan.points.size());
  if (scan.has_time) {
    out->times_from = Inference::kSensor;
    float earliest = 0;
    for (size_t i = 0; i < scan.points.size(); ++i) {
      times_[i] = std::min(0.F, scan.points[i].time);
      earliest = std::min(earliest, times_[i]);
    }
    out->period_s = -earliest;
    return;
  }
  float start = static_cast<float>(model.start_azimuth);
  float per_turn = model.clockwise ? -1.F : 1.F;
  const bool firing_order = std::abs(turns_) > 0.75 && std::abs(turns_) < 1.25;
  out->times_from = firing_order ? Inference::kPointOrder : Inference::kSensorModel;
  if (firing_order) {
    start = azimuths_.front();
    per_turn = turns_ > 0 ? 1.F : -1.F;
  }
  const auto period = static_cast<float>(out->period_s);
  float previous = 0;
  for (size_t i = 0; i < times_.size(); ++i) {
    float fraction = per_turn * (azimuths_[i] - start) / kTurn;
    fraction -= std::floor(fraction);
    // Lasers of one firing look into slightly different directions: at the seam of a scan in
    // firing order a point may seem to be a turn too early or too late.
    if (firing_order && fraction > 0.9F && previous < 0.1F)
      fraction = 0;
    else if (firing_order && fraction < 0.1F && previous > 0.9F)
      fraction = 1;
    previous = fraction;
    times_[i] = (fraction - 1) * period;
  }
}

void RingSorter::Scatter(const Scan& scan, const SensorModel& model, RingScan* out) {
  out->ring_begin.assign(ring_count_ + 1, 0);
  for (size_t i = 0; i < scan.points.size(); ++i) {
    if (InRange(scan.points[i], model)) ++out->ring_begin[rings_[i] + 1];
  }
  for (int ring = 0; ring < ring_count_; ++ring) {
    out->ring_begin[ring + 1] += out->ring_begin[ring];
  }
  out->points.resize(out->ring_begin.back());
  next_.assign(out->ring_begin.begin(), out->ring_begin.end() - 1);
  for (size_t i = 0; i < scan.points.size(); ++i) {
    const ScanPoint& p = scan.points[i];
    if (!InRange(p, model)) continue;
    const float range = std::sqrt(p.x * p.x + p.y * p.y + p.z * p.z);
    out->points[next_[rings_[i]]++] = {p.x, p.y, p.z, p.intensity, times_[i], range};
  }
}

}  // namespace isthmus::floam
