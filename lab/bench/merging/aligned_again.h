// A map refined once more, beside what the server does.
#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "core/map/submap.h"
#include "core/pose.h"

namespace isthmus::bench {

struct MappedSubmap {
  size_t robot = 0;
  std::shared_ptr<const Submap> submap;
};

// T_map_submap after each submap was aligned with all that lie around it, of its own robot and of
// others, and a pose graph of these alignments and the robots' odometry was solved; twice. Begins
// at `T_map_submap`, by submap; the submaps of a robot are in the order in which it drove. The
// same poses where the graph cannot be solved.
std::vector<Pose> AlignAgain(const std::vector<MappedSubmap>& submaps,
                             const std::vector<Pose>& T_map_submap);

}  // namespace isthmus::bench
