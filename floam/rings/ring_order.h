// The order of points within rings, and of rings among each other.
#pragma once

#include <cstdint>
#include <vector>

#include "core/scan.h"
#include "floam/rings/limits.h"
#include "floam/rings/ring_scan.h"

namespace isthmus::floam {

// Counts, over points filed into rings one by one, those out of order and those that repeat.
class OrderWatch {
 public:
  void Add(const RingPoint& before, const RingPoint& p) {
    if (p.time < before.time - kSameRayS) {
      ++backward_;
    } else if (p.time < before.time + kSameRayS && SameDirection(before, p)) {
      ++repeated_;
    }
  }
  // A ring may begin anywhere in the turn.
  bool IsDisordered(size_t points, size_t rings) const {
    return backward_ > 3 * rings + points / 50;
  }
  bool HasTwoReturns(size_t points) const { return repeated_ > points / 50; }

  static bool SameDirection(const RingPoint& a, const RingPoint& b) {
    const float x = a.y * b.z - a.z * b.y, y = a.z * b.x - a.x * b.z, z = a.x * b.y - a.y * b.x;
    const float limit = kSameRaySine * a.range * b.range;
    return x * x + y * y + z * z < limit * limit && a.x * b.x + a.y * b.y + a.z * b.z > 0;
  }

 private:
  size_t backward_ = 0, repeated_ = 0;
};

// Puts the points of every ring in order of time, linear in their number where they come nearly in
// that order or against it. Returns what there was to see of them then.
OrderWatch SortRings(RingScan* scan);

// Keeps the farthest of several returns along one ray, which are neighbours in their ring: what is
// seen through leaves, rain and glass.
void KeepFarthestReturns(RingScan* scan);

// The rank of every ring by elevation, the lowest first, when rings do not come in that order, up
// or down (firing order of Velodyne's lasers); else empty. Rings without points come last.
std::vector<uint16_t> RanksByElevation(const Scan& scan, const std::vector<uint16_t>& rings,
                                       int ring_count);

}  // namespace isthmus::floam
