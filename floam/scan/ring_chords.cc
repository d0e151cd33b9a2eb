#include "floam/scan/ring_chords.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <limits>

#include "floam/scan/features.h"
#include "floam/scan/limits.h"

namespace isthmus::floam {
namespace {

const Eigen::Vector3f kAnywhere =
    Eigen::Vector3f::Constant(std::numeric_limits<float>::quiet_NaN());

float AzimuthCosine(const Eigen::Vector3f& a, const Eigen::Vector3f& b) {
  return a.head<2>().dot(b.head<2>()) / (a.head<2>().norm() * b.head<2>().norm());
}

// The point of [begin, end) that was measured at that time, as nearly as can be, and then from
// there at that azimuth: rings may be fired side by side or one before the other.
const RingPoint* AtAzimuthOf(const TimedPoint& point, const RingPoint* begin, const RingPoint* end,
                             Work* work) {
  if (begin == end) return nullptr;
  const bool rising = begin->time <= end[-1].time;
  const RingPoint* at = std::lower_bound(
      begin, end, point.time,
      [rising](const RingPoint& p, float time) { return rising ? p.time < time : p.time > time; });
  if (at == end) --at;
  const RingPoint* const from = at;
  float best = AzimuthCosine(at->Position(), point.position);
  for (const std::ptrdiff_t step : {-1, 1}) {
    while (at + step >= begin && at + step < end) {
      const float cosine = AzimuthCosine(at[step].Position(), point.position);
      if (!(cosine > best)) break;
      best = cosine;
      at += step;
    }
  }
  work->Add(Work::Kind::kRings, static_cast<uint64_t>(std::abs(at - from)) + 1);
  return best >= kSameAzimuthCosine ? at : nullptr;
}

Eigen::Vector3f Chord(const RingScan& scan, const TimedPoint& point, int side, Work* work) {
  for (int away = 1; away <= kNeighbourRings; ++away) {
    const int ring = point.ring + side * away;
    if (ring < 0 || ring + 1 >= static_cast<int>(scan.ring_begin.size())) break;
    const RingPoint* at = AtAzimuthOf(point, scan.points.data() + scan.ring_begin[ring],
                                      scan.points.data() + scan.ring_begin[ring + 1], work);
    if (at == nullptr) continue;
    const float range = point.position.norm();
    // Half the range is another surface: on a level floor a ring 2 degrees above is so much farther
    // 14 times the sensor's height away.
    if (std::min(range, at->range) < 0.5F * std::max(range, at->range)) return kAnywhere;
    return (at->Position() - point.position).normalized();
  }
  return Eigen::Vector3f::Zero();
}

}  // namespace

std::vector<RingChords> ChordsOf(const RingScan& scan, const std::vector<TimedPoint>& points,
                                 Work* work) {
  std::vector<RingChords> chords;
  if (!scan.in_rings()) return chords;
  chords.reserve(points.size());
  for (const TimedPoint& point : points) {
    if (work->spent()) break;
    chords.push_back({Chord(scan, point, -1, work), Chord(scan, point, 1, work)});
  }
  return chords;
}

bool MayBe(const RingChords& chords, const Eigen::Vector3f& normal) {
  const auto lies_along = [&](const Eigen::Vector3f& chord) {
    return !chord.isZero() && !(std::abs(normal.dot(chord)) >= kLyingCosine);  // True for NaN.
  };
  const bool unknown = chords[0].isZero() && chords[1].isZero();
  return unknown || lies_along(chords[0]) || lies_along(chords[1]);
}

}  // namespace isthmus::floam
