// Limits of the maps that scans are matched to and of what is remembered.
//
// "A guess": nothing that is recorded says that another value was tried. The reach of maps, and how
// much they hold, is in LocalMapOptions and MapMemoryOptions.
#pragma once

#include <cstddef>
#include <cstdint>

namespace isthmus::floam {

// The local map (local_map.h).

// Metres: blocks of eight voxels, a shape in each and one in all. A guess; smaller ones have too
// few points for a shape, larger ones more than one surface.
inline constexpr double kBlockM = 1.0;
// Metres; where blocks begin, on every axis. Built things are often at round coordinates relative
// to where a drive begins, and a wall on the border of voxels is found from one side of it only:
// this is off all multiples of 0.05 m by almost as much as can be.
inline constexpr double kGridOriginM = 0.2236;
// A shape is fitted anew when its points have become more by this factor: time against freshness.
inline constexpr float kRefitGrowth = 1.25F;
// Blocks that each scan looks at for what is out of reach: a matter of time. A guess.
inline constexpr int kEvictedPerScan = 512;
// Times max_blocks beyond which points are not put into new blocks: what comes faster than blocks
// are looked at, as scans of ever other places, would take all memory. A guess: no map in use comes
// near.
inline constexpr size_t kMostBlocksFactor = 2;
// Times max_blocks that a saved map may have: no map in use comes near, so it is damaged.
inline constexpr size_t kMaxAllocatedFactor = 5;

// Shapes (voxel_statistics.h). Guesses, but for the second ring that lines and planes need
// (decision 0017, 0019), which took the place of further limits.

// Points of a plane or line, and of a pole.
inline constexpr float kMinShapePoints = 5;
inline constexpr float kMinPolePoints = 3;
// Variances, m^2: of a pole's points per axis at most; of a plane's along its second axis and a
// line's along its first at least.
inline constexpr float kMaxPoleVariance = 0.15F * 0.15F;
inline constexpr float kMinShapeVariance = 0.09F * 0.09F;
// Smallest over middle eigenvalue of a plane, and middle over largest of a line.
inline constexpr float kMaxFlatness = 0.1F;
inline constexpr float kMaxSlimness = 0.15F;

// The remembered map (map_memory.h).

// Metres: voxels of one point. Finer ones cost memory, coarser ones blur walls.
inline constexpr double kMemoryVoxelM = 0.2;
// A cell holds a wall if so many levels of voxels are seen within so many that follow each other: a
// floor with its noise is in two.
inline constexpr int kWallLevels = 3;
inline constexpr uint32_t kWallWindow = 5;

// The motion by poles (pole_search.cc). Guesses, checked on roads and in forests where drives begin
// at speed (decision 0016).

// The fastest (m/s, rad/s) and the farthest (m, rad) that is looked for.
inline constexpr double kFastestMPerS = 20;
inline constexpr double kFastestRadPerS = 1.6;
inline constexpr double kFarthestPoleM = 6;
inline constexpr double kFarthestPoleRad = 0.8;
// Steps of the search (m, rad): one of them off, a pole still counts for a quarter.
inline constexpr double kPoleStepM = 0.2;
inline constexpr double kPoleStepRad = 0.02;
// Metres: a cell of the picture of poles, finer than the steps.
inline constexpr float kPoleCellM = 0.15F;
// Poles that both scans must show: a few agree with something by chance.
inline constexpr size_t kMinPoles = 4;
// Motions that are worth a closer look, by poles and in all (start.h): each costs a beginning.
inline constexpr size_t kMostMotions = 4;
// Motions that are one, m and rad.
inline constexpr double kSamePoleMotionM = 0.5;
inline constexpr double kSamePoleMotionRad = 0.05;

}  // namespace isthmus::floam
