// Volumes that changed points make up.
#pragma once

#include <vector>

#include "core/records/changed_volumes.h"
#include "server/composition/changes/changed_points.h"

namespace isthmus::composition {

struct VolumeOptions {
  double smallest_m = 0.3;  // Least length of a volume's longest edge.
  bool wants_points = false;
};

// Points of one kind that are near each other are of one volume. Left out is what is smaller or has
// fewer than kFewestPoints; what was seen for a moment only, as people are; what rays pass along
// rather than through; and sheets along a surface that the other side has seen: placement moved
// those. The largest first.
std::vector<ChangedVolume> MakeVolumes(const std::vector<ChangedPoint>& points,
                                       const std::vector<ComparedSubmap>& submaps,
                                       const VolumeOptions& options);

}  // namespace isthmus::composition
