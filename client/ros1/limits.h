// Limits of the ROS 1 bridge: what it holds, how long it waits.
#pragma once

#include <cstddef>

namespace isthmus::ros1 {

// Scans between ROS and the spool: two seconds of a sensor at 10 Hz, for a disk that stalls. When
// full the oldest is dropped. Fewer lose scans to a slow fsync, more only take memory.
inline constexpr size_t kQueuedScans = 20;
// Messages that ROS keeps of each topic for a subscriber that is slow, the oldest dropped: five
// seconds at 10 Hz.
inline constexpr size_t kQueuedMessages = 50;
// Seconds between two complaints about the same thing, so that a log stays readable.
inline constexpr double kComplaintPeriodS = 10;
// Seconds between two scans above which no velocity is given: one scan may be missing at 5 Hz.
inline constexpr double kMaxTwistGapS = 0.5;
// Seconds for an answer that the server has at hand, and for the whole map, before the map's
// thread gives up until its next look. A server that hangs delays the end of the node by so much.
inline constexpr double kCallTimeoutS = 5;
inline constexpr double kMapTimeoutS = 120;
// Seconds that a node which is to finish its session waits for the server at its end: roslaunch
// kills what has not ended 15 s after it asked.
inline constexpr double kFinishS = 10;
// Times that the map's resolution is doubled to fit the limit of points: each leaves about a
// quarter of the surface's points, so 10 are never needed but where the limit is absurd.
inline constexpr int kMaxCoarsenings = 10;
// Sizes of the markers, in sizes of a session's ball.
inline constexpr double kTextSizes = 0.8;
inline constexpr double kLineSizes = 0.15;

}  // namespace isthmus::ros1
