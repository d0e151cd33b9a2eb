#include "floam/rings/ring_order.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace isthmus::floam {
namespace {

bool IsEarlier(const RingPoint& a, const RingPoint& b) { return a.time < b.time; }

// Files sorted by azimuth tell rings against the sense of turning, from anywhere in the turn
// (KITTI): reverses what comes before and after the instant at which the turn ends and begins.
void TurnAround(RingPoint* begin, RingPoint* end, float half_turn_s) {
  RingPoint* part = begin;
  for (RingPoint* p = begin; p != end; ++p) {
    const bool last = p + 1 == end || std::abs(p[1].time - p->time) > half_turn_s;
    if (!last) continue;
    if (IsEarlier(*p, *part)) std::reverse(part, p + 1);
    part = p + 1;
  }
}

// False, and the order any, when too many points are too far from their place.
bool SortNearlySorted(RingPoint* begin, RingPoint* end) {
  std::ptrdiff_t left = 8 * (end - begin);  // Moves, beyond which sorting properly is faster.
  for (RingPoint* p = begin; p + 1 < end; ++p) {
    if (!IsEarlier(p[1], *p)) continue;
    RingPoint* place = p;
    while (place != begin && IsEarlier(p[1], place[-1])) --place;
    left -= p + 1 - place;
    if (left < 0) return false;
    std::rotate(place, p + 1, p + 2);
  }
  return true;
}

}  // namespace

OrderWatch SortRings(RingScan* scan) {
  const auto half_turn_s = static_cast<float>(0.5 * scan->period_s);
  OrderWatch order;
  for (size_t ring = 0; ring + 1 < scan->ring_begin.size(); ++ring) {
    RingPoint* begin = scan->points.data() + scan->ring_begin[ring];
    RingPoint* end = scan->points.data() + scan->ring_begin[ring + 1];
    TurnAround(begin, end, half_turn_s);
    if (!SortNearlySorted(begin, end)) std::stable_sort(begin, end, IsEarlier);
    for (const RingPoint* p = begin; p + 1 < end; ++p) order.Add(p[0], p[1]);
  }
  return order;
}

void KeepFarthestReturns(RingScan* scan) {
  uint32_t kept = 0;
  for (size_t ring = 0; ring + 1 < scan->ring_begin.size(); ++ring) {
    const uint32_t begin = scan->ring_begin[ring], end = scan->ring_begin[ring + 1];
    const uint32_t first = kept;
    scan->ring_begin[ring] = first;
    for (uint32_t i = begin; i < end; ++i) {
      const RingPoint p = scan->points[i];
      if (kept > first && OrderWatch::SameDirection(scan->points[kept - 1], p)) {
        if (p.range > scan->points[kept - 1].range) scan->points[kept - 1] = p;
      } else {
        scan->points[kept++] = p;
      }
    }
  }
  scan->ring_begin.back() = kept;
  scan->points.resize(kept);
}

std::vector<uint16_t> RanksByElevation(const Scan& scan, const std::vector<uint16_t>& rings,
                                       int ring_count) {
  std::vector<double> sine(ring_count, 0);
  std::vector<int> count(ring_count, 0);
  for (size_t i = 0; i < rings.size(); ++i) {
    const ScanPoint& p = scan.points[i];
    sine[rings[i]] += p.z / std::sqrt(p.x * p.x + p.y * p.y + p.z * p.z);
    ++count[rings[i]];
  }
  std::vector<uint16_t> order(ring_count);
  std::iota(order.begin(), order.end(), uint16_t{0});
  const auto seen_end = std::stable_partition(order.begin(), order.end(),
                                              [&](uint16_t ring) { return count[ring] > 0; });
  for (auto ring = order.begin(); ring != seen_end; ++ring) sine[*ring] /= count[*ring];
  const auto lower = [&](uint16_t a, uint16_t b) { return sine[a] < sine[b]; };
  int up = 0, down = 0;
  for (auto ring = order.begin(); ring + 1 < seen_end; ++ring) {
    ++(lower(*ring, *(ring + 1)) ? up : down);
  }
  // A ring or two may be out of order for what they happen to see.
  if (std::min(up, down) <= 1 + (up + down) / 8) return {};
  std::sort(order.begin(), seen_end, lower);
  std::vector<uint16_t> ranks(ring_count);
  for (int rank = 0; rank < ring_count; ++rank) ranks[order[rank]] = static_cast<uint16_t>(rank);
  return ranks;
}

}  // namespace isthmus::floam
