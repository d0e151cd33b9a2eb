// Nearest neighbours among the points of one scan, by ring and azimuth: no tree is built.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

#include "floam/scan/features.h"

namespace isthmus::floam {

// Points of a spinning LiDAR as measured, each with its ring. Nearest on a ring:
// outwards from the azimuth of the query until even the ray is farther away than what was found.
// Nearest of all: on the rings whose elevations come near enough. Exact but for a tenth of a
// millimetre at 10 m (azimuths are, see FastAtan2). Reading is thread safe.
class RingIndex {
 public:
  static constexpr int kNone = -1;

  struct Neighbour {
    int index = kNone;  // For At; not that of the point in what the index was built from.
    float distance2 = std::numeric_limits<float>::infinity();  // m^2.
  };

  // Replaces the contents.
  void Build(const std::vector<TimedPoint>& points);

  size_t size() const { return entries_.size(); }
  const TimedPoint& At(int index) const { return entries_[index].point; }

  // A place to search around; holds its angles, so that several searches share them.
  struct Query {
    explicit Query(const Eigen::Vector3f& at);
    Eigen::Vector3f position;
    float azimuth, elevation, range, horizontal;
  };
  // The nearest within `reach_m`; index kNone if there is none.
  Neighbour Nearest(const Query& query, float reach_m) const;
  // The nearest on that ring, `excluded` apart, if it is nearer than `*best`; rings that do not
  // exist have no points.
  void NearestOnRing(const Query& query, int ring, int excluded, Neighbour* best) const;

  // The points on the same ring, to either side, that lead farthest away from the one at `index`
  // without leaving `reach_m` around it or making a leap of more than half of that.
  std::pair<int, int> Along(int index, float reach_m) const;

  // The points and rings that were looked at since the last call.
  uint64_t TakeSteps() const { return std::exchange(steps_, 0); }

 private:
  struct Entry {
    TimedPoint point;
    float azimuth = 0;
  };
  struct Ring {
    int begin = 0, end = 0;         // In entries_, in order of azimuth.
    float lowest = 0, highest = 0;  // Elevations.
  };

  static bool Before(const Entry& a, const Entry& b);
  void FindRings();  // From entries_.
  // False once the ray to `entry` is farther from the query than `*best`.
  static bool Consider(const Query& query, const Entry& entry, float turned, int index,
                       int excluded, Neighbour* best);

  std::vector<Entry> entries_;  // Ring after ring.
  std::vector<Ring> rings_;
  mutable uint64_t steps_ = 0;
};

}  // namespace isthmus::floam
