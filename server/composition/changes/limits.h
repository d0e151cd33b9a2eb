// Limits of what counts as a change between two states of the map.
//
// Tuned on seeds 1 and 2 of changes_benchmark's museum and warehouse, quoted on others
// (lab/docs/changes.md).
#pragma once

#include <cstddef>
#include <cstdint>

namespace isthmus::composition {

// Edge of the voxels that are compared, metres: that of the map.
inline constexpr double kComparedVoxelM = 0.1;
// Voxels from one within which nothing that the other side has seen may be: 0.2 m.
// What placement leaves between two days' looks at one wall; more takes the lower part of a pallet.
inline constexpr int kStillThereVoxels = 2;
// Voxels, likewise, and cosine: a sheet of which most lies so near to such a surface, along its own
// normal, is that surface, placed worse than usual. A sheet: deviation from its plane, RMS metres.
inline constexpr int kDriftedVoxels = 4;
inline constexpr float kAlongNormal = 0.8f, kSheetM = 0.05f;
// Metres above the lowest and below the highest point around in which floors and ceilings lie that
// the other side has seen from far only; ceilings are this high at least.
inline constexpr float kGroundM = 0.2f, kCeilingM = 2.2f;
// Edge of the squares in which lowest and highest are looked up, with those around.
inline constexpr double kColumnM = 0.5;

// Metres of a ray, from the sensor, in which it says that nothing is there.
inline constexpr float kRayFromM = 0.7f, kRayToM = 25;
// Metres and a share of the range: so much before its end it says so no more. As in visibility/,
// what placement and noise leave; a ray along a wall or floor ends in it.
inline constexpr float kRayEndM = 0.25f, kRayEndPerM = 0.015f;
// Edge of the cells that a ray passes, metres: two voxels, as what was seen well by one side may
// have been met by few rays of the other.
inline constexpr double kPassedCellM = 0.2;
// Steps in which a ray is followed where no such cell is near, metres. Speed alone.
inline constexpr float kStrideM = 0.5f;
// Keyframes of the other side whose rays must pass, at least: one may lie wrong by itself.
inline constexpr int kFewestPasses = 2;
// Metres behind a point, across its surface, at which they must pass as well, of a fifth of a
// volume's points: rays graze a thing that is still there, but do not go through it. Of what moved
// half and more are passed there, of walls that lie wrong one in sixteen at most.
inline constexpr float kPassedBehindM = 0.3f;
inline constexpr double kPassedShare = 0.2;
inline constexpr int kNormalVoxels = 3;  // Around a point, of which its surface is made.
// Odds that a ray passes by error, to one: at most so many keyframes count as independent.
inline constexpr double kPassOdds = 1.0 / 9;
inline constexpr int kMostPasses = 4;
// Keyframes of its own side that look through a point, for each that sees it: more, and it moves.
inline constexpr int kOwnPassesPerHit = 2;

// Edges of cells of which those that touch are of one volume, level and upright: rings of a sparse
// LiDAR are 0.35 m apart at 10 m.
inline constexpr float kGapM = 0.2f, kGapUpM = 0.3f;
// Seconds over which parts of kPartM of a volume must have been seen, half of them: people that
// walk pass in less.
inline constexpr double kSteadyS = 2.5, kPartM = 0.3;
// Points of a volume at least: fewer are what noise leaves at edges.
inline constexpr size_t kFewestPoints = 12;

// Voxels of both sides that are compared in one call: some 80 bytes each, 250 MB; 20,000 m2 of
// rooms.
inline constexpr size_t kMostComparedVoxels = size_t{3} << 20;
// Points of a submap between two questions whether to go on: some milliseconds.
inline constexpr size_t kRaysAtOnce = size_t{1} << 14;
// Places that are told of one volume, thinned evenly: a message of 240 kB.
inline constexpr size_t kMostPlaces = 20000;

}  // namespace isthmus::composition
