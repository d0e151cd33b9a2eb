// Limits of composition beside ComposerOptions: how memory is shared, and pieces of work.
//
// All of them are of speed and memory; the map does not depend on them. Where no source is named a
// number is a guess that was never varied by itself (lab/docs/composition.md).
#pragma once

#include <cstddef>
#include <cstdint>

namespace isthmus::composition {

// One part in so many of the memory is for thinned submaps, the rest for tiles, which readers ask
// for; one in so many of the tiles is for one submap, so that none with stray points takes all.
inline constexpr size_t kThinnedParts = 3;
inline constexpr int kSubmapTilesParts = 8;
// One part in so many, of what thinned submaps have, is for views, where points leave that were
// looked through: a megabyte each. Fewer are read and made again for each new submap near them.
inline constexpr size_t kViewsParts = 6;
// Share of a composition's time that reading and thinning take, for what is said of its progress.
inline constexpr double kReadingShare = 0.8;

// Points between two questions whether to go on: some milliseconds.
inline constexpr size_t kPointsAtOnce = size_t{1} << 16;
// Points whose voxels are prefetched together: more than the memory has in flight, less than a
// cache.
inline constexpr size_t kPrefetchedPoints = 64;
// Edge, in voxels, of the blocks in which a thinned submap's points stand together; a power of two.
inline constexpr int32_t kBlockVoxels = 16;

// Levels of detail of a tile, each with voxels of twice the edge: 12.8 m at the coarsest where they
// have 0.1 m, a handful of points to a tile of 20 m. A tile keeps four bytes for each and robot.
inline constexpr uint32_t kDetailLevels = 8;
// Tiles of higher levels that are kept once made, in bytes of their points, for all readers: a
// screen full of them, some tens of 1 to 2 MB. Fewer, and readers of one place make them anew.
inline constexpr size_t kPyramidBytes = size_t{32} << 20;

// A thinner's table: bits of its size at first; it shrinks when for so many clouds in a row it had
// this many slots per voxel. After a tile of a million points every tile of one point cost a
// millisecond without; large clouds that come now and then still find it ready.
inline constexpr int kFirstTableBits = 12;
inline constexpr size_t kRoomySlots = 16;
inline constexpr int kRoomyClouds = 32;

}  // namespace isthmus::composition
