// Limits of what counts as looking at a point, and of what such a look says.
//
// Tuned on seeds 1 and 2 of moving_benchmark's museum and campus, quoted on others
// (lab/docs/moving.md).
#pragma once

#include <cstddef>
#include <cstdint>

namespace isthmus::composition {

// Metres between which a look at a point counts. Nearer, the robot itself and whoever carries it
// spoil it; farther, it says next to nothing, see kGapRad, and costs as much.
inline constexpr float kNearestLookM = 0.7f, kFarthestLookM = 25;
// Metres, and a share of the range: what was measured has to lie so much behind a point to have
// been seen through it. Noise, the voxel's size, and what an odometry drifts within a submap.
inline constexpr float kBehindM = 0.15f, kBehindPerM = 0.01f;
// Radians: a ray passes a point by so much, at an edge of what was measured. On a level surface
// that is met at a slant it ends the farther behind the point for it. Without, one in a thousand
// points of floors and ceilings leaves; twice as much keeps two people in a hundred.
inline constexpr float kBesideRad = 0.0087f;
// Sine of the elevation, 3 degrees, below which a surface is taken to be met at that: at the
// horizon no margin would do.
inline constexpr float kHorizonSine = 0.05f;
// Metres and radians on top between submaps: what placement may be off by. Less takes walls that
// two drives see 0.2 m apart for gone.
inline constexpr float kPlacementM = 0.1f, kPlacementRad = 0.005f;

// Views of a submap at most, evenly spread over its keyframes: 33 kB each, and time. Submaps of 15
// m have some 15; an upload may have 65535.
inline constexpr size_t kMostViews = 48;
// Views of a submap that are asked about another's points, likewise: time.
inline constexpr size_t kAskedViews = 8;

// Log odds, natural, are counted in steps of this.
inline constexpr float kLogOddsStep = 0.125f;
// Points that are passed over together where they are out of a view's reach; they lie within some
// metres. Speed alone.
inline constexpr size_t kGroupPoints = 128;

// Probabilities of what a view says about a point at which it looks.
// Something is measured there if something is there, and if nothing is there any more.
inline constexpr float kOnIfThere = 0.8f, kOnIfGone = 0.1f;
// The view looks through if nothing is there.
inline constexpr float kThroughIfGone = 0.9f;
// The view looks through although something is there: at least this, by errors of poses and at
// edges, ...
inline constexpr float kThroughIfThere = 0.1f;
// ... and more where a thing of kThingM may hide between two rays that are kGapRad apart, which is
// a sparse LiDAR's rings: P = 1 - kThingM / (kGapRad range).
inline constexpr float kThingM = 0.3f, kGapRad = 0.035f;

// Log odds in steps. What all views of one submap may say about a point: they err together.
inline constexpr int32_t kMinOwn = -64, kMaxOwn = 24;
inline constexpr int32_t kMinOther = -32, kMaxOther = 24;
// Below this a point is gone: the odds are 12 to 1 against it. One look never is enough.
inline constexpr int32_t kGoneBelow = -20;
// Keyframes over which what came is seen at least. Who walks by is in one place for fewer; more
// would have things leave that were seen in passing.
inline constexpr int kStandsKeyframes = 2;
// And the share of its points that a later keyframe sees again, at least: a car that drives by is
// seen for a while, too, but hardly a point of it twice.
inline constexpr float kStandsSeenAgain = 0.05f;

// The same thing, see MarkGone: metres to what is gone, along and across the vertical, and above
// the ground; and keyframes between which both were seen. More takes what stands beside a way, less
// leaves shoes in the map.
inline constexpr float kSameThingHighM = 0.5f, kSameThingWideM = 0.5f, kAboveGroundM = 0.04f;
inline constexpr int kSameThingKeyframes = 1;
// Rounds of that, each with the points that are gone after the round before.
inline constexpr int kSameThingRounds = 3;

}  // namespace isthmus::composition
