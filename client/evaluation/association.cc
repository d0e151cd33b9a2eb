#include "client/evaluation/association.h"

#include <algorithm>
#include <iterator>

namespace isthmus::evaluation {
namespace {

Trajectory InOrderOfTime(Trajectory trajectory) {
  std::stable_sort(
      trajectory.begin(), trajectory.end(),
      [](const StampedPose& a, const StampedPose& b) { return a.stamp_ns < b.stamp_ns; });
  return trajectory;
}

double SecondsBetween(int64_t a_ns, int64_t b_ns) {
  return 1e-9 * static_cast<double>(a_ns < b_ns ? b_ns - a_ns : a_ns - b_ns);
}

// The index of the pose nearest in time; of an empty trajectory 0.
size_t NearestInTime(const Trajectory& sorted, int64_t stamp_ns) {
  const auto after = std::lower_bound(
      sorted.begin(), sorted.end(), stamp_ns,
      [](const StampedPose& pose, int64_t stamp) { return pose.stamp_ns < stamp; });
  if (after == sorted.begin()) return 0;
  const auto before = std::prev(after);
  const bool is_before = after == sorted.end() || SecondsBetween(before->stamp_ns, stamp_ns) <=
                                                      SecondsBetween(after->stamp_ns, stamp_ns);
  return static_cast<size_t>((is_before ? before : after) - sorted.begin());
}

}  // namespace

std::vector<PosePair> Associate(const Trajectory& truth, const Trajectory& estimate,
                                double tolerance_s) {
  const Trajectory sorted = InOrderOfTime(truth);
  std::vector<PosePair> pairs;
  size_t used = sorted.size();  // The true pose of the pair before; none yet.
  for (const StampedPose& entry : InOrderOfTime(estimate)) {
    const size_t nearest = NearestInTime(sorted, entry.stamp_ns);
    if (sorted.empty()) break;
    const int64_t true_ns = sorted[nearest].stamp_ns;
    const double apart_s = SecondsBetween(true_ns, entry.stamp_ns);
    if (!(apart_s <= tolerance_s)) continue;
    const PosePair pair{entry.stamp_ns, sorted[nearest].pose, entry.pose};
    if (nearest != used) {
      pairs.push_back(pair);
    } else if (apart_s < SecondsBetween(true_ns, pairs.back().stamp_ns)) {
      pairs.back() = pair;
    }
    used = nearest;
  }
  return pairs;
}

std::vector<double> WayAlongTruth(const std::vector<PosePair>& pairs) {
  std::vector<double> way;
  for (size_t i = 0; i < pairs.size(); ++i) {
    way.push_back(
        i == 0 ? 0
               : way.back() +
                     (pairs[i].truth.translation() - pairs[i - 1].truth.translation()).norm());
  }
  return way;
}

}  // namespace isthmus::evaluation
