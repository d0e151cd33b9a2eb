#include "floam/rings/ring_scan.h"

#include <absl/strings/str_cat.h>

#include <Eigen/Core>
#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "floam/rings/limits.h"
#include "floam/rings/ring_order.h"
#include "floam/rings/scan_pattern.h"

namespace isthmus::floam {
namespace {

const char* RingSource(Inference from, const SensorModel& model) {
  switch (from) {
    case Inference::kSensor:
      return ", given";
    case Inference::kPointOrder:
      return ", one after the other";
    case Inference::kSensorModel:
      return ", by the sensor's elevations";
    case Inference::kHistogram:
    case Inference::kNone:
      break;
  }
  return model.elevations.empty() ? ", by the elevations seen"
                                  : ", by the elevations seen, which are not the named sensor's";
}

}  // namespace

absl::Status RingSorter::Sort(const Scan& scan, const SensorModel& model, double period_s,
                              RingScan* out) {
  if (absl::Status status = Validate(scan, model); !status.ok()) return status;
  if (model.spins && rings_at_from_ != Inference::kNone) {
    is_shuffled_ = false;
    absl::Status status = SortIntoRings(scan, model, period_s, out);
    if (!status.ok() && scans_ == 0 && out->rings_from == Inference::kPointOrder) {
      // Points in no order seem to turn as often as those of ring after ring.
      is_shuffled_ = true;
      if (SortIntoRings(scan, model, period_s, out).ok()) return absl::OkStatus();
    }
    // A scan that does not look like one of the named sensor, whose rings are known, is another
    // sensor's.
    if (status.ok() || scans_ > 0 || model.rings > 0) return status;
  }
  SortIntoBands(scan, model, period_s, out);
  ++scans_;
  return absl::OkStatus();
}

absl::Status RingSorter::SortIntoRings(const Scan& scan, const SensorModel& model, double period_s,
                                       RingScan* out) {
  if (absl::Status status = AssignRings(scan, model, out); !status.ok()) return status;
  AssignTimes(scan, model, period_s, out);
  Scatter(scan, out);
  if (scans_ == 0) {
    if (absl::Status status = CheckFirst(scan, model, *out); !status.ok()) return status;
  }
  ++scans_;
  Describe(model, out);
  return absl::OkStatus();
}

absl::Status RingSorter::Validate(const Scan& scan, const SensorModel& model) {
  Eigen::Array4f low = Eigen::Array4f::Constant(1e9F), high = -low;  // And of intensities.
  const auto min_range2 = static_cast<float>(model.min_range_m * model.min_range_m);
  const auto max_range2 = static_cast<float>(model.max_range_m * model.max_range_m);
  ranges_.resize(scan.points.size());
  float* range = ranges_.data();
  size_t usable = 0;
  float earliest = scan.points.empty() ? 0 : scan.points[0].time, latest = earliest;
  lowest_ring_ = std::numeric_limits<uint16_t>::max();
  highest_ring_ = 0;
  // Sums of 0 * x are NaN as soon as one x is not finite: one test at the end instead of one per
  // value.
  float poison = 0;
  for (const ScanPoint& p : scan.points) {
    poison += 0 * (p.x + p.y + p.z) + 0 * p.time;
    earliest = std::min(earliest, p.time);
    latest = std::max(latest, p.time);
    lowest_ring_ = std::min<int>(lowest_ring_, p.ring);
    highest_ring_ = std::max<int>(highest_ring_, p.ring);
    const float range2 = p.x * p.x + p.y * p.y + p.z * p.z;
    const bool in_range = range2 >= min_range2 && range2 <= max_range2;
    *range++ = in_range ? std::sqrt(range2) : -1;
    if (!in_range) continue;
    const Eigen::Map<const Eigen::Array4f> position(&p.x);
    low = low.min(position);
    high = high.max(position);
    ++usable;
  }
  if (!std::isfinite(poison)) {
    return absl::InvalidArgumentError(absl::StrCat(
        "scan ", scan.sequence, " has coordinates or times that are not finite; drop such points"));
  }
  if (usable < kMinScanPoints) {
    return absl::InvalidArgumentError(absl::StrCat("scan ", scan.sequence, " has ", usable, " of ",
                                                   scan.points.size(), " points between ",
                                                   model.min_range_m, " m and ", model.max_range_m,
                                                   " m; at least ", kMinScanPoints, " are needed"));
  }
  if ((high - low).head<3>().maxCoeff() < kMinScanExtentM) {
    return absl::InvalidArgumentError(
        absl::StrCat("all points of scan ", scan.sequence, " are in one place"));
  }
  if (scan.has_time && (earliest < -kMaxScanS || latest > kClockSlackS)) {
    return absl::InvalidArgumentError(absl::StrCat(
        "scan ", scan.sequence, " has point times from ", earliest, " s to ", latest,
        " s; they must be relative to the END of the scan, within the last ", kMaxScanS, " s"));
  }
  has_times_ = scan.has_time && earliest < 0;
  if (model.spins && scan.has_ring && highest_ring_ >= kMaxRings) {
    return absl::InvalidArgumentError(absl::StrCat("scan ", scan.sequence, " names ring ",
                                                   highest_ring_, "; at most ", kMaxRings,
                                                   " are supported"));
  }
  return absl::OkStatus();
}

void RingSorter::SortIntoBands(const Scan& scan, const SensorModel& model, double period_s,
                               RingScan* out) {
  rings_at_from_ = out->rings_from = Inference::kNone;
  ring_count_ = static_cast<int>(std::lround(kPi / kBandRad));
  ComputeElevations(scan, BeamOrigin(), &elevations_);
  rings_.resize(scan.points.size());
  for (size_t i = 0; i < scan.points.size(); ++i) {
    const int band = static_cast<int>((elevations_[i] + kPi / 2) / kBandRad);
    rings_[i] = static_cast<uint16_t>(std::clamp(band, 0, ring_count_ - 1));
  }
  if (has_times_) {
    AssignTimes(scan, model, period_s, out);
  } else {
    times_.assign(scan.points.size(), 0);
    out->times_from = scan.has_time ? Inference::kSensor : Inference::kNone;
    out->period_s = turn_period_.Update(scan.end_stamp_ns, period_s);
    out->is_compensated = scan.has_time;
  }
  Scatter(scan, out);
  out->text.rings = "none: surfaces from neighbourhoods";
  out->text.times = scan.has_time ? "given" : "not given: motion within a scan is not compensated";
  out->text.warning.clear();
}

absl::Status RingSorter::AssignRings(const Scan& scan, const SensorModel& model, RingScan* out) {
  // A field that names one ring for all is one that nobody filled.
  const bool given = scan.has_ring && (highest_ring_ > lowest_ring_ || model.rings == 1);
  if (!given || !has_times_) ComputeAzimuths(scan, &azimuths_);
  out->rings_from = Inference::kSensor;
  return given ? TakeGivenRings(scan, model) : InferRings(scan, model, out);
}

absl::Status RingSorter::TakeGivenRings(const Scan& scan, const SensorModel& model) {
  if (absl::Status status = CheckRingCount(scan.sequence, lowest_ring_, highest_ring_, model);
      !status.ok()) {
    return status;
  }
  rings_.resize(scan.points.size());
  for (size_t i = 0; i < scan.points.size(); ++i) rings_[i] = scan.points[i].ring;
  ring_count_ = highest_ring_ + 1;
  if (scans_ > 0 && !rings_unordered_) return absl::OkStatus();
  const std::vector<uint16_t> ranks = RanksByElevation(scan, rings_, ring_count_);
  rings_unordered_ = !ranks.empty();
  if (!rings_unordered_) return absl::OkStatus();
  for (uint16_t& ring : rings_) ring = ranks[ring];
  return absl::OkStatus();
}

absl::Status RingSorter::InferRings(const Scan& scan, const SensorModel& model, RingScan* out) {
  const double turns = CountTurns(azimuths_);
  if (rings_at_.empty() && !is_shuffled_ && std::abs(turns) >= kRingByRingTurns) {
    if (!seam_known_) {
      ComputeElevations(scan, origin_, &elevations_);
      seam_ = FindSeam(azimuths_, elevations_);
      seam_known_ = true;
    }
    out->rings_from = Inference::kPointOrder;
    ring_count_ = RingsByWrap(azimuths_, turns, seam_, &rings_);
    return CheckRingCount(scan.sequence, 0, ring_count_ - 1 - model.rings / 8, model);
  }
  ComputeElevations(scan, origin_, &elevations_);
  if (absl::Status status = FindElevations(scan, model); !status.ok()) return status;
  RingsByElevation(elevations_, rings_at_, &rings_);
  out->rings_from = rings_at_from_;
  ring_count_ = static_cast<int>(rings_at_.size());
  return absl::OkStatus();
}

// Keeps the model's elevations where the first scan fits them; else those that scans show, which
// get better with every one.
absl::Status RingSorter::FindElevations(const Scan& scan, const SensorModel& model) {
  const bool known = !rings_at_.empty();
  if (known && rings_at_from_ == Inference::kSensorModel) return absl::OkStatus();
  if (known && histogram_scans_ >= kHistogramScans) return absl::OkStatus();
  double misfit = 1;
  if (!known && !model.elevations.empty()) {
    misfit = RingsByElevation(elevations_, model.elevations, &rings_);
  }
  if (misfit > kGoodRingFit) {
    if (!known) {
      origin_ = FindBeamOrigin(scan);
      ComputeElevations(scan, origin_, &elevations_);
    }
    histogram_.Add(scan, elevations_);
    ++histogram_scans_;
    if (known && !std::has_single_bit(histogram_scans_)) return absl::OkStatus();
    std::vector<double> peaks = histogram_.Peaks();
    const double peaks_misfit = peaks.empty() ? 1 : RingsByElevation(elevations_, peaks, &rings_);
    if (peaks_misfit < kMaxRingMisfit && peaks_misfit < misfit) {
      // Elevations that blur may show more rings than there are, but not twice as many.
      const int highest = static_cast<int>(peaks.size()) - 1 - model.rings / 2;
      absl::Status status = CheckRingCount(scan.sequence, 0, highest, model);
      if (!known && !status.ok()) return status;
      if (status.ok()) rings_at_ = std::move(peaks);
      rings_at_from_ = Inference::kHistogram;
      return absl::OkStatus();
    }
  }
  if (known) return absl::OkStatus();
  if (misfit > kMaxRingMisfit) {
    histogram_ = ElevationHistogram();
    histogram_scans_ = 0;
    origin_ = BeamOrigin();
    return NotSpinning(scan.sequence, "its points do not gather at certain elevations");
  }
  rings_at_ = model.elevations;
  rings_at_from_ = Inference::kSensorModel;
  origin_ = BeamOrigin();
  ComputeElevations(scan, origin_, &elevations_);
  return absl::OkStatus();
}

void RingSorter::AssignTimes(const Scan& scan, const SensorModel& model, double period_s,
                             RingScan* out) {
  out->period_s = turn_period_.Update(scan.end_stamp_ns, period_s);
  out->is_compensated = scan.has_time && !has_times_;
  if (has_times_) {
    times_.resize(scan.points.size());
    out->times_from = Inference::kSensor;
    float earliest = 0;
    for (size_t i = 0; i < scan.points.size(); ++i) {
      times_[i] = std::min(0.F, scan.points[i].time);
      earliest = std::min(earliest, times_[i]);
    }
    out->period_s = -earliest;
    return;
  }
  clock_.Assign(azimuths_, rings_, ring_count_, model, out->period_s, &times_);
  out->times_from = clock_.from_order() ? Inference::kPointOrder : Inference::kSensorModel;
  if (out->is_compensated) out->times_from = Inference::kSensor;
}

void RingSorter::Scatter(const Scan& scan, RingScan* out) {
  out->ring_begin.assign(ring_count_ + 1, 0);
  for (size_t i = 0; i < scan.points.size(); ++i) {
    out->ring_begin[rings_[i] + 1] += ranges_[i] >= 0 ? 1 : 0;
  }
  for (int ring = 0; ring < ring_count_; ++ring) {
    out->ring_begin[ring + 1] += out->ring_begin[ring];
  }
  out->points.resize(out->ring_begin.back());
  next_.assign(out->ring_begin.begin(), out->ring_begin.end() - 1);
  OrderWatch order;
  for (size_t i = 0; i < scan.points.size(); ++i) {
    const ScanPoint& p = scan.points[i];
    if (ranges_[i] < 0) continue;
    const uint32_t at = next_[rings_[i]]++;
    out->points[at] = {p.x, p.y, p.z, p.intensity, times_[i], ranges_[i]};
    if (at > out->ring_begin[rings_[i]]) order.Add(out->points[at - 1], out->points[at]);
  }
  const bool sortable = out->in_rings();
  if (sortable && order.IsDisordered(out->points.size(), ring_count_)) order = SortRings(out);
  if (order.HasTwoReturns(out->points.size())) KeepFarthestReturns(out);
}

absl::Status RingSorter::CheckFirst(const Scan& scan, const SensorModel& model,
                                    const RingScan& sorted) {
  absl::Status status = CheckSpinning(sorted, scan.sequence);
  mismatch_ = ElevationMismatch(sorted, model);
  seam_known_ = seam_known_ && status.ok();
  return status;
}

void RingSorter::Describe(const SensorModel& model, RingScan* out) {
  int seen = 0;
  for (int k = 0; k < ring_count_; ++k) seen += out->ring_begin[k + 1] > out->ring_begin[k] ? 1 : 0;
  rings_seen_ = std::max(rings_seen_, seen);
  out->text.rings = absl::StrCat(rings_seen_, RingSource(out->rings_from, model));
  if (out->times_from == Inference::kSensor) {
    out->text.times = "given";
  } else {
    const double start_deg = std::round(clock_.start_azimuth() * 180 / std::numbers::pi);
    out->text.times = absl::StrCat(
        "from azimuth, ", clock_.clockwise() ? "clockwise" : "counter-clockwise", " from ",
        start_deg, " deg, ",
        clock_.from_order() ? "as the points follow each other" : "assumed for the sensor");
  }
  out->text.warning = mismatch_;
  if (2 * rings_seen_ < model.rings) {
    absl::StrAppend(&out->text.warning, mismatch_.empty() ? "" : "; ", rings_seen_,
                    " rings seen, but a ", model.name, " has ", model.rings);
  }
}

}  // namespace isthmus::floam
