// A submap thinned once, in its own frame, so that composing it again at another pose touches a
// fraction of its points.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "core/map/submap.h"
#include "server/composition/keep_on.h"
#include "server/composition/voxel_thinner.h"

namespace isthmus::composition {

// Tells a submap from another of the same id: one that came after the first one's session was
// deleted, or of another database.
struct SubmapFingerprint {
  int64_t first_stamp_ns = 0, last_stamp_ns = 0;
  uint64_t first_sequence = 0, last_sequence = 0;
  uint64_t points = 0, keyframes = 0;
  uint64_t content = 0;  // SubmapInfo's; 0: not known.

  friend bool operator==(const SubmapFingerprint&, const SubmapFingerprint&) = default;
  // For state_codec.h.
  template <typename Self, typename Io>
  static void Fields(Self& self, Io& io) {
    io(self.first_stamp_ns, self.last_stamp_ns, self.first_sequence, self.last_sequence,
       self.points, self.keyframes, self.content);
  }
};

SubmapFingerprint FingerprintOf(const SubmapInfo& submap);
// True if it is that submap, as far as can be told without its content.
bool CoversTheSame(const Submap& submap, const SubmapFingerprint& meant);

struct ThinnedSubmap {
  // Submap frame. Points in one cube of kBlockVoxels stand together, so that a tile's points are in
  // few places.
  std::vector<WeightedPoint> points;
  Box bounds;  // Around the points, submap frame.
};

// Leaves out points that are not finite or off the grid. Nothing when told to end.
std::optional<ThinnedSubmap> Thin(const Submap& submap, const VoxelGrid& grid,
                                  VoxelThinner* thinner, const KeepOn& keep_on);

// The largest distance that any point of the box moves when its pose changes from one to the other.
// Exact: the displacement is affine in the point, so a corner has the largest.
double LargestMove(const Box& box, const Pose& T_map_source, const Pose& T_map_source_new);

}  // namespace isthmus::composition
