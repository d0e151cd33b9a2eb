// Limits by which trajectories are judged and maps are drawn.
#pragma once

#include <cstddef>

namespace isthmus::evaluation {

// KITTI's benchmark of odometry (Geiger et al., "Are we ready for autonomous driving?", CVPR 2012,
// and its development kit): segments of 100, 200 ... 800 m, begun at every tenth pose.
inline constexpr double kKittiStepM = 100;
inline constexpr size_t kSegmentLengths = 8;
inline constexpr size_t kKittiStride = 10;

// A drive shorter than this, in metres, gets shorter segments, begun at every pose: it would have
// hardly any of KITTI's. Twice the shortest of those.
inline constexpr double kShortDriveM = 200;
// The share of a short drive that its longest segment may take: what begins later than the rest of
// it is not seen. Chosen so that a fifth of the poses still begin one of that length.
inline constexpr double kLongestSegment = 0.8;

// Pictures from above. Metres per bit of a pixel's heights: half a step of stairs and more are told
// apart, noise is not.
inline constexpr double kHeightStep = 0.25;
// Heights beyond, in metres, are no place but damage: none is so far from where a robot began.
inline constexpr float kHighest = 1e6f;
// The share of a picture's longer side that lines of its grid lie apart, at most.
inline constexpr double kGridShare = 0.12;
// Heights at which a pixel has its full colour: a wall of 1.5 m.
inline constexpr int kFullHeights = 6;

}  // namespace isthmus::evaluation
