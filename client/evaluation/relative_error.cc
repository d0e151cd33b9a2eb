#include "client/evaluation/relative_error.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "client/evaluation/limits.h"

namespace isthmus::evaluation {
namespace {

Pose MotionError(const PosePair& from, const PosePair& to) {
  return (from.truth.Inverse() * to.truth).Inverse() * (from.estimate.Inverse() * to.estimate);
}

double AngleDeg(const Pose& pose) { return RotationAngle(pose) * 180 / std::numbers::pi; }

// The way along to each pair, in the unit of the delta.
std::vector<double> Progress(const std::vector<PosePair>& pairs, DeltaUnit unit) {
  if (unit == DeltaUnit::kMetres) return WayAlongTruth(pairs);
  std::vector<double> progress;
  for (size_t i = 0; i < pairs.size(); ++i) {
    progress.push_back(unit == DeltaUnit::kFrames
                           ? static_cast<double>(i)
                           : 1e-9 * static_cast<double>(pairs[i].stamp_ns - pairs[0].stamp_ns));
  }
  return progress;
}

double RoundDown(double length) {
  const double power = std::pow(10, std::floor(std::log10(length)));
  for (const double factor : {5.0, 2.0}) {
    if (factor * power <= length) return factor * power;
  }
  return power;
}

}  // namespace

RelativeErrors CompareSteps(const std::vector<PosePair>& pairs, const Delta& delta) {
  // Stamps and ways are sums: without a margin a step of just the delta would often be missed.
  const double least = delta.value * (1 - 1e-9);
  const std::vector<double> progress = Progress(pairs, delta.unit);
  std::vector<double> m, deg;
  size_t j = 0;
  for (size_t i = 0; i < pairs.size(); ++i) {
    j = std::max(j, i + 1);
    while (j < pairs.size() && progress[j] - progress[i] < least) ++j;
    if (j >= pairs.size()) break;
    const Pose error = MotionError(pairs[i], pairs[j]);
    m.push_back(error.translation().norm());
    deg.push_back(AngleDeg(error));
  }
  return {Summarize(std::move(m)), Summarize(std::move(deg))};
}

std::vector<double> SegmentLengths(double way_m) {
  std::vector<double> lengths;
  if (!(way_m > 0)) return lengths;
  const bool is_short = way_m < kShortDriveM;
  const double step = is_short ? RoundDown(kLongestSegment * way_m / kSegmentLengths) : kKittiStepM;
  for (size_t i = 1; i <= kSegmentLengths; ++i) {
    const double length = step * static_cast<double>(i);
    if (length < way_m) lengths.push_back(length);
  }
  return lengths;
}

DriftErrors CompareSegments(const std::vector<PosePair>& pairs) {
  const std::vector<double> way = WayAlongTruth(pairs);
  DriftErrors out;
  out.is_kitti = !way.empty() && way.back() >= kShortDriveM;
  out.stride = out.is_kitti ? kKittiStride : 1;
  size_t count = 0;
  for (const double length : SegmentLengths(way.empty() ? 0 : way.back())) {
    SegmentErrors errors{length, {}, {}};
    for (size_t i = 0; i < pairs.size(); i += out.stride) {
      const auto end =
          std::upper_bound(way.begin() + static_cast<ptrdiff_t>(i), way.end(), way[i] + length);
      if (end == way.end()) break;
      const Pose error = MotionError(pairs[i], pairs[static_cast<size_t>(end - way.begin())]);
      errors.percent.push_back(100 * error.translation().norm() / length);
      errors.deg_per_100m.push_back(100 * AngleDeg(error) / length);
      out.percent += errors.percent.back();
      out.deg_per_100m += errors.deg_per_100m.back();
      ++count;
    }
    if (!errors.percent.empty()) out.lengths.push_back(std::move(errors));
  }
  if (count > 0) {
    out.percent /= static_cast<double>(count);
    out.deg_per_100m /= static_cast<double>(count);
  }
  return out;
}

}  // namespace isthmus::evaluation
