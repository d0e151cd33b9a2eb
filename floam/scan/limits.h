// Limits by which points become features, surroundings and pictures.
//
// "A guess": nothing that is recorded says that another value was tried. The number of features,
// and their roughness, is in FeatureOptions.
#pragma once

#include <cstddef>
#include <cstdint>

#include "core/geometry/angles.h"

namespace isthmus::floam {

// Metres, one sigma: of the ranges of all sensors (data sheets say 1 to 3 cm), and so of points off
// a perfect plane. Too small, and scans are trusted more than the motion before.
inline constexpr double kRangeNoiseM = 0.02;

// Steps that dealing with a scan may take (work.h), 6 to 10 ns each: a second of a core. Measured
// of 128 rings of 2048 points in a room: 1.5 million for most scans, 10 for the second of a drive,
// 18 for one by which a lost robot is looked for; of 300,000 points in a shaft 1 m wide without
// rings: 1,600, 9 s. Smaller, and scans of denser sensors are rejected; larger, and one robot holds
// a thread for longer.
inline constexpr uint64_t kMaxScanWork = 100'000'000;

// Points of one surface (features.cc, neighbourhood.cc).

// Neighbours farther apart than this (m, and m per m of range along a ring: the spacing on a wall
// that is seen at about 10 degrees) belong to different things. Guesses.
inline constexpr float kSurfaceGapM = 0.25F;
inline constexpr float kSurfaceGapPerM = 0.02F;
// Cosine of the angle between ray and surface along a ring; above it is grazing. A guess.
inline constexpr float kGrazingCosine = 0.97F;
// Smoothness at which a surface's weight has fallen to 1/e: the paper's local weight. A guess.
inline constexpr float kSmoothnessScale = 0.02F;
// Cosine of the angle between points next to each other on a ring; below it, a degree, nothing came
// back from in between. Sensors measure every 0.1 to 0.4 degrees (data sheets).
inline constexpr float kEmptyCosine = 0.99985F;

// Things too slim, or going along (features.cc).

// Metres; what is thinner is no pole unless it is that far away, but a flake of dust or a drop
// (decision 0016).
inline constexpr float kThinM = 0.03F;
inline constexpr float kThinFromM = 10;
// Metres; what stands free nearer than this, and is no wider, may be a part of the robot. Two bare
// tunnels (30 and 0.6 % off, then 0.06 and 0.11), checked on 40 fresh drives (decision 0019).
inline constexpr float kOwnM = 2;
inline constexpr float kOwnWidthM = 1;

// Density of features (features.cc).

// Scale of the voxels above which it may be halved: a quarter at last. A guess.
inline constexpr float kLeastVoxelScale = 0.3F;
// Times few_surfaces that there are when voxels grow again: more than the four times that halving
// brings at most, or they would change with every scan.
inline constexpr size_t kPlentySurfaces = 5;
// Surfaces that face the same way, without rings: more ground would outvote the few walls. A guess.
inline constexpr size_t kMaxPerFacing = 400;

// Neighbourhoods without rings (neighbourhood.cc). Guesses, on simulated solid state and Livox
// sensors; two were changed so that more of what is far or has a border is a surface.

// Radians: the sizes of a cell, the largest of which also measures density; and the points that one
// is to hold.
inline constexpr float kSmallestCellRad = 0.8F * kDegree;
inline constexpr float kLargestCellRad = 3 * kDegree;
inline constexpr float kPointsPerCell = 2.2F;
// Tangent of the angle of incidence up to which a surface is followed; 5 at first.
inline constexpr float kSteepestSlope = 3;
// Neighbours that a plane needs (it has four unknowns), and their share of all that is around (0.6
// at first).
inline constexpr size_t kMinPlaneNeighbours = 6;
inline constexpr float kMinAlikeShare = 0.4F;
// Metres per metre of range that neighbours may be off a plane beyond surface_deviation_m: farther
// away they are farther from each other, and fewer things are flat.
inline constexpr float kDeviationPerM = 0.0015F;
// The plane's fit: the unit of time, per second, in which the sensor's motion is of the size of the
// other unknowns, and the ridge that keeps at zero what the neighbours do not tell.
inline constexpr float kPlaneTimePerS = 10;
inline constexpr float kPlaneRidge = 1e-3F;
// Metres: what is slim is no thicker and wider, and what is beside it is farther by so much.
inline constexpr float kSlimThicknessM = 0.3F;
inline constexpr float kSlimHalfWidthM = 0.2F;
inline constexpr float kSlimBehindM = 0.5F;
// Points on it, and on each side of it; its length in cells, of the three that are looked at.
inline constexpr size_t kMinOnSlim = 3;
inline constexpr size_t kMinBesideSlim = 2;
inline constexpr float kMinSlimLength = 1.6F;

// Rings beside a ring (ring_chords.cc, ScanToScan).

// Rings to the next one, at most: one may have seen nothing there. As A-LOAM's.
inline constexpr int kNeighbourRings = 2;
// Cosine of the difference in azimuth, 1.8 degrees, within which points lie above each other. A
// guess.
inline constexpr float kSameAzimuthCosine = 0.9995F;
// Cosine of the angle between chord and normal of one surface: rough ones bend on the way. Larger,
// and false steep planes hold back a car that drives off in a tunnel (decision 0017).
inline constexpr float kLyingCosine = 0.4F;

// Scans as pictures (scan_image.cc). Guesses; checked where robots were carried (decision 0019).

// Two points of a wall above each other: metres of rise, and horizontal over vertical distance.
inline constexpr float kMinWallRiseM = 0.1F;
inline constexpr float kMaxWallLean = 0.6F;
// Rings that are compared for it: much closer ones show more noise than shape.
inline constexpr int kRingsCompared = 20;
// A point is where something was seen if it is this near, m and m per m of range.
inline constexpr float kSightToleranceM = 0.4F;
inline constexpr float kSightTolerancePerM = 0.01F;
// Share of the rings' distance; farther from the nearest ring nobody looked.
inline constexpr float kSightRingReach = 0.3F;

}  // namespace isthmus::floam
