#include "floam/state/unfinished_submap.h"

#include <algorithm>
#include <limits>

namespace isthmus::floam {
namespace {

// Column by column, which compresses best.
struct Columns {
  std::vector<uint64_t> sequences;
  std::vector<int64_t> stamps_ns;
  std::vector<Pose> poses;
  std::vector<float> x, y, z, intensity;
  std::vector<uint16_t> keyframes;

  template <typename Self, typename Io>
  static void Fields(Self& self, Io& io) {
    io(self.sequences, self.stamps_ns, self.poses, self.x, self.y, self.z, self.intensity,
       self.keyframes);
  }
  bool IsSound() const {
    const size_t scans = sequences.size(), points = x.size();
    return scans > 0 && scans <= std::numeric_limits<uint16_t>::max() &&
           stamps_ns.size() == scans && poses.size() == scans && y.size() == points &&
           z.size() == points && intensity.size() == points && keyframes.size() == points &&
           std::is_sorted(keyframes.begin(), keyframes.end()) &&
           (points == 0 || keyframes.back() < scans);
  }
};

template <typename Self, typename Io>
void Scalars(Self& submap, Io& io) {
  io(submap.T_odom_submap, submap.drift_covariance, submap.first_sequence, submap.last_sequence,
     submap.first_stamp_ns, submap.last_stamp_ns);
}

}  // namespace

void WriteUnfinished(const Submap& submap, StateWriter& io) {
  Columns columns;
  for (const Keyframe& keyframe : submap.keyframes) {
    columns.sequences.push_back(keyframe.sequence);
    columns.stamps_ns.push_back(keyframe.stamp_ns);
    columns.poses.push_back(keyframe.T_submap_sensor);
  }
  for (const SubmapPoint& point : submap.points) {
    columns.x.push_back(point.x);
    columns.y.push_back(point.y);
    columns.z.push_back(point.z);
    columns.intensity.push_back(point.intensity);
    columns.keyframes.push_back(point.keyframe);
  }
  Scalars(submap, io);
  io(columns);
}

void ReadUnfinished(StateReader& io, Submap& submap) {
  Columns columns;
  Scalars(submap, io);
  io(columns);
  io.Expect(columns.IsSound());
  if (!io.ok()) return;
  for (size_t i = 0; i < columns.sequences.size(); ++i) {
    submap.keyframes.push_back({columns.sequences[i], columns.stamps_ns[i], columns.poses[i]});
  }
  submap.points.reserve(columns.x.size());
  for (size_t i = 0; i < columns.x.size(); ++i) {
    submap.points.push_back(
        {columns.x[i], columns.y[i], columns.z[i], columns.intensity[i], columns.keyframes[i]});
  }
}

}  // namespace isthmus::floam
