#include "server/placement/corrected_trajectory.h"

#include <algorithm>
#include <limits>

namespace isthmus::placement {
namespace {

// A knot that is placed, and what takes odom to the map there.
struct Correction {
  int64_t stamp_ns = 0;
  Pose T_odom_submap, T_map_submap;

  Pose Apply(const Pose& T_odom_sensor) const {
    return T_map_submap * (T_odom_submap.Inverse() * T_odom_sensor);
  }
};

std::vector<Correction> Corrections(const std::vector<TrajectoryKnot>& knots,
                                    const Placement& placement) {
  std::vector<Correction> corrections;
  auto submap = placement.submaps.begin();
  for (const TrajectoryKnot& knot : knots) {
    while (submap != placement.submaps.end() && submap->index < knot.index) ++submap;
    if (submap == placement.submaps.end()) break;
    if (submap->index != knot.index) continue;
    corrections.push_back({knot.stamp_ns, knot.T_odom_submap, submap->T_map_submap});
  }
  return corrections;
}

double Apart(const Pose& a, const Pose& b) { return (a.translation() - b.translation()).norm(); }

// Corrects the entries [first, last), which lie between two knots, each by its share of the path;
// of the time if there is no path.
void Between(const std::vector<TrajectoryEntry>& entries, size_t first, size_t last,
             const Correction& from, const Correction& to, Trajectory* trajectory) {
  std::vector<double> gone;
  double path_length = 0;
  Pose at = from.T_odom_submap;
  for (size_t i = first; i < last; ++i) {
    path_length += Apart(at, entries[i].T_odom_sensor);
    at = entries[i].T_odom_sensor;
    gone.push_back(path_length);
  }
  path_length += Apart(at, to.T_odom_submap);
  const double duration = static_cast<double>(to.stamp_ns - from.stamp_ns);
  for (size_t i = first; i < last; ++i) {
    const TrajectoryEntry& entry = entries[i];
    const double share = path_length > 0 ? gone[i - first] / path_length
                                         : static_cast<double>(entry.stamp_ns - from.stamp_ns) /
                                               std::max(1.0, duration);
    trajectory->push_back({entry.stamp_ns, Interpolate(from.Apply(entry.T_odom_sensor),
                                                       to.Apply(entry.T_odom_sensor), share)});
  }
}

}  // namespace

Trajectory CorrectTrajectory(const std::vector<TrajectoryEntry>& entries,
                             const std::vector<TrajectoryKnot>& knots, const Placement& placement) {
  const std::vector<Correction> corrections = Corrections(knots, placement);
  Trajectory trajectory;
  trajectory.reserve(entries.size());
  size_t next = 0;  // The first correction that is later than the entry.
  for (size_t i = 0; i < entries.size();) {
    const TrajectoryEntry& entry = entries[i];
    while (next < corrections.size() && corrections[next].stamp_ns <= entry.stamp_ns) ++next;
    if (next > 0 && next < corrections.size()) {
      size_t last = i + 1;
      while (last < entries.size() && entries[last].stamp_ns < corrections[next].stamp_ns) ++last;
      Between(entries, i, last, corrections[next - 1], corrections[next], &trajectory);
      i = last;
      continue;
    }
    const Pose pose = corrections.empty()
                          ? placement.T_map_odom * entry.T_odom_sensor
                          : corrections[next == 0 ? 0 : next - 1].Apply(entry.T_odom_sensor);
    trajectory.push_back({entry.stamp_ns, pose});
    ++i;
  }
  return trajectory;
}

}  // namespace isthmus::placement
