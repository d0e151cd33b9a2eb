// Limits of prepared submaps and maps: what is kept of a submap, and what free space is asked of
// it.
//
// Where no source is named a number is a guess that was never varied by itself. All of them
// together were in view on merging_benchmark's seeds 11 to 20 and held on 21 to 30
// (lab/docs/merging.md).
#pragma once

#include <cstddef>

#include "server/pose_graph/information.h"

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
// Speed, but for the number of comparisons, which probabilities are made of.
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
// Metres: what stands alone and is less wide and high is a person, or as easily moved, and is not
// asked; and edge of voxels that hang together if they touch, as two of a VLP-16's rings are 0.6 m
// apart at 17 m. Calibrated on a car park of seed 9500, its right place has a third fewer
// contradicted regions for it and its 49 wrong ones 4 % fewer.
inline constexpr float kSmallWideM = 1.2f, kSmallHighM = 2.2f, kTogetherM = 0.6f;
// Points of a column, by the views of one submap, from which on it counts as a region: fewer say
// little. And the share of them in front from which on it is contradicted.
inline constexpr int64_t kMinRegionComparisons = 6;
inline constexpr double kContradictedRegion = 0.5;
// Metres between which a look at a point counts for retiring its submap.
inline constexpr float kMinLookM = 0.5f, kMaxLookM = 60;

// Agreement of surfaces.

// Points of a submap that are asked about it; and metres from a map's surface within which they
// count as seen by it.
inline constexpr size_t kMaxAgreementPoints = 1500;
inline constexpr float kSeenM = 1.0f;
// |n_z| up to which a surface stands upright, 60 degrees.
inline constexpr float kMaxUprightNormalZ = 0.5f;

// Things (decision 0038). All were chosen on pairs of furnished flats, offices, storeys and car
// parks (wild worlds of seeds 9240 to 9268).

// Metres over the ground between which things are looked for: below is the floor.
inline constexpr float kThingsFromM = 0.15f, kThingsToM = 1.8f;
// Metres: cells whose lowest upward surface is ground; voxels of a point each; squares that are a
// thing each; and from a sensor, beyond which it sees too few points of one.
inline constexpr double kThingsGroundCellM = 1.0;
inline constexpr float kThingVoxelM = 0.1f, kThingM = 0.5f, kThingsSeenM = 12;
// Keyframes that see a voxel: what fewer saw is dust, or walked by.
inline constexpr int kLeastSeen = 2;
// Points that a thing has at least, and that are asked of it at most; and the share of them that is
// there or looked through, from which on something is known of it.
inline constexpr size_t kLeastThingPoints = 5, kThingPoints = 32;
inline constexpr double kLeastThingSeen = 0.4;
// Metres of a straight stretch from which on it is taken for a wall, the share of its cells that
// are filled, but for gaps, the height that stands upright in such a cell, and directions tried.
inline constexpr float kWallM = 1.6f, kWallFilled = 0.8f, kUprightM = 0.4f;
inline constexpr int kWallDirections = 36;
// Metres between the origins of submaps from which on they are taken for different storeys.
inline constexpr double kThingsStoreyM = 2.5;
// Metres within which a point lies on the other map, and how much of them heights are; and metres,
// and share of the range, by which what was measured has to lie behind one that was looked through.
inline constexpr float kOnThingM = 0.08f, kThingHeightWeight = 0.4f;
inline constexpr float kThroughM = 0.15f, kThroughPerM = 0.02f;

// Maps.

// Share of all surfaces that floors, and walls, have to be, or one plane alone says which way is
// up.
inline constexpr double kMinSurfaceShare = 0.03;
// A map grown by this factor is another: its level and its repeats are estimated, and pairs with it
// are searched, anew. Less searches whole maps with every submap, more misses better places for
// longer.
inline constexpr double kNewMapGrowth = 1.25;

// Metres and radians by which a map has to be moved to lie on itself elsewhere; and the share of
// the score in place from which on a way to do so is looked at.
inline constexpr double kRepeatShiftM = 1.0, kRepeatTurnRad = 0.09;
inline constexpr double kMinRepeatScore = 0.1;
// Degree of repeating from which on a way to do so counts, how many do, and metres: voxels in which
// a map stands on what it repeats. Guesses.
inline constexpr double kMinRepeatDegree = 0.15;
inline constexpr size_t kMostMoves = 4;
inline constexpr float kRepeatedVoxelM = 0.25f;

// Shapes of sessions.

// The odometry by which loops are looked for and judged, from submap to submap: a bad one, 1 % and
// 0.05 degrees per metre, far worse than ours (lab/docs/mapping.md). A better one would
// discard right loops of a robot that drifts.
inline constexpr pose_graph::DriftModel kPoorOdometry = {.position_m = 0.02,
                                                         .position_per_m = 0.01,
                                                         .rotation_rad = 0.0035,
                                                         .rotation_per_m = 0.00087,
                                                         .rotation_per_rad = 0.01};
// Times that a session's drift may be taken for larger, in its variance, than that of any: as much
// as its loops show it to be. LoopOptions::drift_sigmas squared: loops are found by no more.
inline constexpr double kMaxDriftScale = 16;

// Metres, and over pose_graph::kLeverM radians: submaps that loops have moved against each other by
// less are matched as they lay before. Half of kFreeSpaceMarginM, which then hides it; less makes
// maps anew, and judges their pairs again, for what joint refinement takes out anyway.
inline constexpr double kReshapedM = 0.2;
// A session that goes on is given another shape only when it has grown by this factor: then all
// shapes that it ever has cost a fixed number of times as much as the last.
inline constexpr double kReshapeGrowth = 1.1;
// Seconds of one optimisation of a shape; the best so far is taken then. As placement's.
inline constexpr double kMaxShapeSeconds = 10;

}  // namespace isthmus::matching
