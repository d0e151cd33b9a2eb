#include "floam/match/ring_index.h"

#include <algorithm>
#include <cmath>

#include "core/geometry/angles.h"

namespace isthmus::floam {
namespace {

// A lower bound of the sine of an angle >= 0, and beyond a right angle of one: what is behind
// cannot be nearer than the axis. Two of FastAtan2 may be off.
float SineBound(float angle) {
  const float a = std::min(std::max(angle - 2 * 1e-5F, 0.F), 1.4F);
  return a - a * a * a * (1.F / 6);
}

float Elevation(const Eigen::Vector3f& p) { return FastAtan2(p.z(), std::hypot(p.x(), p.y())); }

}  // namespace

RingIndex::Query::Query(const Eigen::Vector3f& at)
    : position(at),
      azimuth(FastAtan2(at.y(), at.x())),
      range(at.norm()),
      horizontal(std::hypot(at.x(), at.y())) {
  elevation = FastAtan2(at.z(), horizontal);
}

void RingIndex::Build(const std::vector<TimedPoint>& points) {
  entries_.clear();
  for (const TimedPoint& p : points) {
    entries_.push_back({p, FastAtan2(p.position.y(), p.position.x())});
  }
  std::sort(entries_.begin(), entries_.end(), Before);
  FindRings();
}

bool RingIndex::Before(const Entry& a, const Entry& b) {
  return a.point.ring != b.point.ring ? a.point.ring < b.point.ring : a.azimuth < b.azimuth;
}

void RingIndex::FindRings() {
  rings_.assign(entries_.empty() ? 0 : entries_.back().point.ring + 1, Ring());
  const auto count = static_cast<int>(entries_.size());
  for (int begin = 0; begin < count;) {
    const int number = At(begin).ring;
    Ring& ring = rings_[number];
    ring.begin = ring.end = begin;
    ring.lowest = ring.highest = Elevation(At(begin).position);
    for (; ring.end < count && At(ring.end).ring == number; ++ring.end) {
      const float elevation = Elevation(At(ring.end).position);
      ring.lowest = std::min(ring.lowest, elevation);
      ring.highest = std::max(ring.highest, elevation);
    }
    begin = ring.end;
  }
}

bool RingIndex::Consider(const Query& query, const Entry& entry, float turned, int index,
                         int excluded, Neighbour* best) {
  const float bound = query.horizontal * SineBound(turned);
  if (bound * bound >= best->distance2) return false;
  const float distance2 = (entry.point.position - query.position).squaredNorm();
  if (distance2 < best->distance2 && index != excluded) *best = {index, distance2};
  return true;
}

void RingIndex::NearestOnRing(const Query& query, int ring, int excluded, Neighbour* best) const {
  if (ring < 0 || ring >= static_cast<int>(rings_.size())) return;
  const auto [begin, end, lowest, highest] = rings_[ring];
  const auto first =
      std::lower_bound(entries_.begin() + begin, entries_.begin() + end, query.azimuth,
                       [](const Entry& entry, float azimuth) { return entry.azimuth < azimuth; });
  const int start = static_cast<int>(first - entries_.begin());
  const int count = end - begin;
  // Once around each way at most: half a turn is beyond any bound but that of a point on the axis.
  int index = start;
  int k = 0;
  for (; k < count; ++k, ++index) {
    if (index == end) index = begin;
    float turned = entries_[index].azimuth - query.azimuth;
    if (turned < 0) turned += 2 * kPi;
    if (!Consider(query, entries_[index], turned, index, excluded, best)) break;
  }
  steps_ += k + 1;
  index = start - 1;
  for (k = 0; k < count; ++k, --index) {
    if (index < begin) index = end - 1;
    float turned = query.azimuth - entries_[index].azimuth;
    if (turned < 0) turned += 2 * kPi;
    if (!Consider(query, entries_[index], turned, index, excluded, best)) break;
  }
  steps_ += k;
}

RingIndex::Neighbour RingIndex::Nearest(const Query& query, float reach_m) const {
  Neighbour best;
  best.distance2 = reach_m * reach_m;
  const auto off_elevation = [&](const Ring& ring) {
    return std::max(ring.lowest - query.elevation, query.elevation - ring.highest);
  };
  int likely = kNone;
  steps_ += rings_.size();
  for (size_t ring = 0; ring < rings_.size(); ++ring) {
    if (rings_[ring].begin == rings_[ring].end) continue;
    if (likely == kNone || off_elevation(rings_[ring]) < off_elevation(rings_[likely])) {
      likely = static_cast<int>(ring);
    }
  }
  NearestOnRing(query, likely, kNone, &best);
  for (size_t ring = 0; ring < rings_.size(); ++ring) {
    if (static_cast<int>(ring) == likely) continue;
    const float bound = query.range * SineBound(off_elevation(rings_[ring]));
    if (bound * bound < best.distance2) {
      NearestOnRing(query, static_cast<int>(ring), kNone, &best);
    }
  }
  return best;
}

std::pair<int, int> RingIndex::Along(int index, float reach_m) const {
  const TimedPoint& from = At(index);
  const Ring& ring = rings_[from.ring];
  const int size = ring.end - ring.begin;
  const auto lead = [&](int step) {
    int at = index;
    for (int left = size - 1; left > 0; --left, ++steps_) {
      const int next = ring.begin + (at - ring.begin + step + size) % size;
      const Eigen::Vector3f& p = At(next).position;
      if ((p - from.position).squaredNorm() > reach_m * reach_m) break;
      if ((p - At(at).position).squaredNorm() > 0.25F * reach_m * reach_m) break;
      at = next;
    }
    return at;
  };
  return {lead(-1), lead(1)};
}

}  // namespace isthmus::floam
