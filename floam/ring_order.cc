#include "floam/ring_order.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace isthmus::floam {

void SortRings(RingScan* scan) {
  const auto at = [&](uint32_t i) { return scan->points.begin() + static_cast<std::ptrdiff_t>(i); };
  for (size_t ring = 0; ring + 1 < scan->ring_begin.size(); ++ring) {
    std::stable_sort(at(scan->ring_begin[ring]), at(scan->ring_begin[ring + 1]),
                     [](const RingPoint& a, const RingPoint& b) { return a.time < b.time; });
  }
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
