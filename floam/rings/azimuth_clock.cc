#include "floam/rings/azimuth_clock.h"

#include <algorithm>
#include <cmath>

#include "core/geometry/angles.h"
#include "floam/rings/limits.h"

namespace isthmus::floam {
namespace {

float Median(std::vector<float>* values) {
  const auto middle = values->begin() + static_cast<std::ptrdiff_t>(values->size() / 2);
  std::nth_element(values->begin(), middle, values->end());
  return *middle;
}

}  // namespace

double TurnPeriod::Update(int64_t end_stamp_ns, double assumed_s) {
  const double interval_s = 1e-9 * static_cast<double>(end_stamp_ns - last_ns_);
  if (last_ns_ != 0 && interval_s >= kShortestTurnS && interval_s <= kLongestTurnS) {
    if (intervals_s_.size() == kTurnIntervals) intervals_s_.erase(intervals_s_.begin());
    intervals_s_.push_back(interval_s);
  }
  last_ns_ = end_stamp_ns;
  if (intervals_s_.size() < kTurnIntervals / 3) return assumed_s;
  std::vector<double> sorted = intervals_s_;
  std::sort(sorted.begin(), sorted.end());
  const double median_s = sorted[sorted.size() / 2];
  const bool faster = median_s < (1 - kUnlikePeriod) * assumed_s;
  // Longer intervals may be scans that were dropped, unless there is none of the assumed length.
  const bool slower = sorted.front() > (1 + kUnlikePeriod) * assumed_s;
  return faster || slower ? median_s : assumed_s;
}

void AzimuthClock::Assign(const std::vector<float>& azimuths, const std::vector<uint16_t>& rings,
                          int ring_count, const SensorModel& model, double period_s,
                          std::vector<float>* times) {
  times->resize(azimuths.size());
  const auto period = static_cast<float>(period_s);
  from_order_ = Follow(azimuths, rings, ring_count, model);
  if (!from_order_) {
    sense_ = model.clockwise ? -1.F : 1.F;
    start_ = static_cast<float>(model.start_azimuth);
    for (size_t i = 0; i < azimuths.size(); ++i) {
      (*times)[i] = (TurnsSince(azimuths[i], start_) - 1) * period;
    }
    return;
  }
  float start = MedianStart();
  CountTurns(azimuths, rings, start, times);
  float extent = MedianExtent();
  if (extent >= kWholeTurnShare * whole_turns_) {
    start_ = start;
    whole_turns_ = extent;
    start_known_ = true;
  } else {
    if (start_known_) CountTurns(azimuths, rings, start_, times);
    if (!start_known_) start_ = start;
    whole_turns_ = std::max(extent, kWholeTurnFading * whole_turns_);
    extent = whole_turns_;
  }
  for (float& t : *times) t = std::min(0.F, (t / extent - 1) * period);
}

bool AzimuthClock::Follow(const std::vector<float>& azimuths, const std::vector<uint16_t>& rings,
                          int ring_count, const SensorModel& model) {
  size_t changes = 0;
  for (size_t i = 1; i < rings.size(); ++i) changes += rings[i] != rings[i - 1] ? 1 : 0;
  ring_by_ring_ = changes < rings.size() / 4;
  if (model.sorted_files && ring_by_ring_) return false;
  rings_.assign(ring_count, Ring());
  for (size_t i = 0; i < azimuths.size(); ++i) {
    Ring& ring = rings_[rings[i]];
    if (ring.count++ == 0) {
      ring.first = azimuths[i];
    } else if (const float step = WrapOnce(azimuths[i] - ring.last);
               std::abs(step) < kTurningStepRad) {
      ring.forward += step;
      ring.path += std::abs(step);
    }
    ring.last = azimuths[i];
  }
  uint32_t most = 0;
  float forward = 0, path = 0;
  for (const Ring& ring : rings_) {
    most = std::max(most, ring.count);
    forward += ring.forward;
    path += ring.path;
  }
  if (std::abs(forward) < kMinForwardShare * path) return false;
  sense_ = forward > 0 ? 1.F : -1.F;
  full_rings_.clear();
  for (uint32_t k = 0; k < rings_.size(); ++k) {
    if (static_cast<float>(rings_[k].count) > kFullRingShare * static_cast<float>(most)) {
      full_rings_.push_back(k);
    }
  }
  return true;
}

float AzimuthClock::TurnsSince(float azimuth, float start) const {
  return Fraction(sense_ * (azimuth - start) / (2 * kPi));
}

float AzimuthClock::MedianStart() const {
  const float reference = rings_[full_rings_.front()].first;
  scratch_.clear();
  for (const uint32_t k : full_rings_) scratch_.push_back(WrapOnce(rings_[k].first - reference));
  return WrapOnce(reference + Median(&scratch_));
}

float AzimuthClock::MedianExtent() const {
  scratch_.clear();
  for (const uint32_t k : full_rings_) scratch_.push_back(rings_[k].turns);
  return Median(&scratch_);
}

void AzimuthClock::CountTurns(const std::vector<float>& azimuths,
                              const std::vector<uint16_t>& rings, float start,
                              std::vector<float>* turns) {
  float progress = 0;  // Progress of the ring being told, or of all if they are told together.
  float back = kAsideAtStartTurns;
  for (size_t i = 0; i < azimuths.size(); ++i) {
    Ring& ring = rings_[rings[i]];
    if (ring_by_ring_ && (i == 0 || rings[i] != rings[i - 1])) {
      progress = 0;
      back = kAsideAtStartTurns;
    }
    const float since = TurnsSince(azimuths[i], start) - (progress - back);
    ring.turns = Fraction(since) + (progress - back);
    progress += (ring_by_ring_ ? 1.F : kProgressFading) * (ring.turns - progress);
    if (progress > kAsideTurns) back = kAsideTurns;
    (*turns)[i] = ring.turns;
  }
}

}  // namespace isthmus::floam
