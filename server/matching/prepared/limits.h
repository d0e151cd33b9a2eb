// Limits of prepared submaps and maps: what is kept of a submap, and what free space is asked of
// it.
//
// Where no source is named a number is a guess that was never varied by itself. All of them
// together were in view on merging_benchmark's seeds 11 to 20 and held on 21 to 30 (BENCHMARK.md,
// Merging).
#pragma once

#include <cstddef>

namespace isthmus::matching {

// Submaps. These shape what is stored: another value wants another kPreparedSubmapKind.

// Metres or radians between the keyframes whose views are kept. More leaves free space unseen
// behind corners.
inline constexpr double kViewSpacingM = 1.0, kViewTurnRad = 0.5;
// Views of a submap, each 33 kB: a record of ever so many spread keyframes cannot take all memory.
// Submaps of 15 m have some 15.
inline constexpr size_t kMaxViews = 1000;
// Points of a submap that are moved when it is aligned. More take time, fewer miss small surfaces.
inline constexpr size_t kAlignedPoints = 1000;

// Free space.

// Metres, and a share of the range: a point that lies by more in front of what was measured is
// contradicted. By geometry a bin of 2 degrees spans 3.5 % of the range, less where it is met
// head-on; the rest is drift. Less contradicts right matches, more lets twins pass.
inline constexpr double kFreeSpaceMarginM = 0.4, kFreeSpaceMarginPerM = 0.01;
// Metres between the points that are asked, and edge of the squares by which they are passed over.
// Speed, but for the number of comparisons, which min_comparisons counts.
inline constexpr float kAskedSpacingM = 0.4f, kAskedColumnM = 4.0f;
// Cosine, 78 degrees: flatter, a surface has no range of its own in a bin of 2 degrees.
inline constexpr float kMinIncidenceCosine = 0.2f;
// Metres: nearer, the robot itself and the bins' smallness spoil the comparison.
inline constexpr float kMinComparedM = 1.0f;
// Share of a point's own views that may contradict it, and views that have to agree with it: else
// it moves, as people and foliage do. The benchmark's walkers and cars are the test of it.
inline constexpr float kMaxFleeting = 0.2f;
inline constexpr int kMinAgreeingViews = 3;
// Views of a map from which on that is asked: of fewer there may be none that see it thrice.
inline constexpr size_t kEnoughViews = 12;
// Metres between which a look at a point counts for retiring its submap.
inline constexpr float kMinLookM = 0.5f, kMaxLookM = 60;

// Maps.

// Share of all surfaces that floors, and walls, have to be, or one plane alone says which way is
// up.
inline constexpr double kMinSurfaceShare = 0.03;
// A map grown by this factor is another: its level is estimated, and pairs with it are searched,
// anew. Less searches whole maps with every submap, more misses better places for longer.
inline constexpr double kNewMapGrowth = 1.25;

}  // namespace isthmus::matching
