// Limits of the files that are made for other programs.
#pragma once

#include <cstddef>

namespace isthmus::exports {

// Metres along each side of a tile unless told otherwise: what Autoware recommends.
inline constexpr double kTileM = 20;
// Bytes of tiles that are held before they are written out.
inline constexpr size_t kTileBytesHeld = size_t{64} << 20;

// Points of one PointCloud message, 40 MB. Foxglove shows the newest message of a topic, so what is
// beyond goes to a topic of its own; larger messages make it slow to seek.
inline constexpr size_t kCloudPoints = 2'000'000;

}  // namespace isthmus::exports
