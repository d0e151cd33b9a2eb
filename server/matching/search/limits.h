// Limits of the search: what is level, what is outdoors, how plan views and places are compared.
//
// Where no source is named a number is a guess that was never varied by itself. All of them
// together were in view on merging_benchmark's seeds 11 to 20 and held on 21 to 30
// (lab/docs/merging.md).
#pragma once

#include <cstddef>
#include <numbers>

namespace isthmus::matching {

// Floors and walls.

// |n_z| from which a surface is floor or ceiling (32 degrees), and up to which it is wall (66).
// What lies between, a ramp or a hedge, is neither.
inline constexpr float kMinLevelNormalZ = 0.85f, kMaxWallNormalZ = 0.4f;
// Surfaces: of fewer no vertical is made, and more make none better.
inline constexpr size_t kMinLevelSurfaces = 50, kMaxLevelSurfaces = 20'000;
// The gate around the vertical narrows from the tilt that is possible to this, 4 degrees, in so
// many rounds. Wider, ramps count as floors; narrower, noise of normals leaves too few.
inline constexpr double kLevelGateRad = 0.07;
inline constexpr int kLevelRounds = 8;

// Up, where odom's z may be anything; up_candidates_test turns maps at will.

// Gates for normals along and across a hypothesised vertical: cosine and sine of about 10 degrees,
// three times the hypotheses' spacing.
inline constexpr float kAlongUpCosine = 0.985f, kAcrossUpSine = 0.17f;
// Two of 10 degrees are one; nearer ones could not be told apart by those gates.
inline constexpr double kDistinctUpRad = 10 * std::numbers::pi / 180;
// Directions on half the sphere, by geometry 3.2 degrees apart; and cells of a normal's quotients,
// 2.4 degrees wide. Fewer may step over the vertical; time grows with either.
inline constexpr int kUpHypotheses = 2000;
inline constexpr float kNormalCellsPerUnit = 24;
// Axes that are looked at closely (a box-shaped room has three), radians between them, and that
// each may be moved. Fewer may leave out the vertical of a hall with many walls.
inline constexpr size_t kMaxUpAxes = 8;
inline constexpr double kUpAxisSpacingRad = 0.35, kUpRefinementRad = 0.15;
// Metres that a floor is thick along the axis. More takes furniture for floors.
inline constexpr float kPlaneThicknessM = 0.3f;
// The map's spread along an axis, over its largest, at which the axis is believed half as much:
// maps are flat. Too small, a tall hall has no vertical.
inline constexpr double kHalfFlatness = 0.5;
// Shares of the way from floor to ceiling: where the sensors stood sways up and down by no more.
inline constexpr double kMinSensorHeight = 0.2;
// Share of its way that the sensor went along an axis, as a root mean square of cosines, from which
// on the axis is believed half as much, and no less, as stairs are climbed: robots and people move
// across the vertical. And metres of way that say little, as one who stands sways too.
inline constexpr double kHalfClimb = 0.3, kLeastPathM = 0.3;
// Radians, 29 degrees, that most sensors lean by at most; and the share of the best axis from which
// on one that near to odom's z is taken. Only in tunnels, which are as high as wide, another axis
// was the likelier one (wild worlds of seeds 9240 to 9269 and 9600 to 9621).
inline constexpr double kMaxLeanRad = 0.5, kBelieveUprightShare = 0.8;

// A sensor stands upright so many times as often as it hangs: a guess, as kUpsideDownLogOdds is. In
// the same worlds the wrong end was the likelier one in 28 of 92 maps under a roof, by 30 times at
// most, and in 2 of 57 under the sky, where the right end is likelier by 8 times at the median.
inline constexpr double kUprightOdds = 100;
inline constexpr double kUprightCosine = 0.5;  // 60 degrees: beyond, neither end is upright.
// The other end is tried too, which takes as long again, where it is no less likely than this share
// of the one that is believed: of a sensor that stands, and of others.
inline constexpr double kDoubtfulStanding = 0.5, kDoubtfulUp = 0.05;

// Outdoors.

// At most this many ceilings are seen per floor, ...
inline constexpr double kMaxCeilingShare = 0.15;
// ... and at least this share of what is seen is this far, metres, from wherever the robot was.
// Wrong, a hall is searched as a street: coarser, and by higher walls.
inline constexpr double kMinFarShare = 0.5;
inline constexpr float kFarM = 12;

// Plan views.

// Cells of a plane over a map, of ground or of shifts, whose planes take some 200 MB. Larger maps
// are looked at more coarsely, and their ground is cut off.
inline constexpr int kMaxPlanCells = 4'000'000;
// Metres: a cell of the ground; above the median of so many cells on either side by this step it is
// the top of a table or car. A smaller step takes steep ground for tops.
inline constexpr double kGroundCellM = 1.0;
inline constexpr float kTopStepM = 0.4f;
inline constexpr int kTopWindow = 2;
// Metres between keyframes whose rays are drawn: turning on the spot adds nothing.
inline constexpr float kRaySpacingM = 0.7f;
// Directions of a keyframe's rays: at 30 m they lie half a metre apart, two cells.
inline constexpr int kAzimuthBins = 360;
// Layers of the band of heights; a wall that fills half of them counts in full.
inline constexpr int kWallLayers = 8;
// The score of two walls in one place whichever way they face, beside the cosine between them. At 0
// posts and shelves say nothing, at 1 parallel sides of a corridor are alike.
inline constexpr float kUnorientedShare = 0.3f;

// The bird's-eye search over yaw and shift.

// The first pass is at so many times the cell: at 4 degrees of yaw images do not fit better. It
// gives so many peaks of each yaw, and so many of all are polished. Too few lose the right one
// where maps share little; time grows with them.
inline constexpr double kCoarseFactor = 2.0;
inline constexpr size_t kPeaksPerYaw = 30, kPolishedPlacements = 200;
// Radians: peaks within this yaw of a better one are its neighbours, less than two steps of yaw.
// More leaves out a rival that is turned little, less spends the polishing on one peak's flanks.
inline constexpr double kSuppressYawRad = 0.12;
// One free cell in so many is asked when a placement is polished. Speed alone.
inline constexpr size_t kFreeStride = 3;
// Cells that both maps saw of the ground, from which on they alone give the height between the
// maps.
inline constexpr size_t kMinSharedGroundCells = 10;

// The search over what stands on the ground, whitened. Tuned on wild pairs of seeds 1111 to 1120
// (lab/docs/merging.md).

// Frequencies to either side over which a spectrum's power is averaged before it is divided by; and
// the least power, as a share of the mean, that it is divided by. Less follows the noise.
inline constexpr int kSpectrumReach = 2;
inline constexpr double kLeastPower = 0.02;
// Metres: layers of a column of space over the ground, from the lowest to 32 layers up; under a
// roof only those below most ceilings count.
inline constexpr float kStructureLayerM = 0.25f, kLowestStructureM = 0.3f;
inline constexpr int kLayersUnderRoof = 8;
// Metres from where a robot was that things are drawn, under a roof and under the sky; cells there.
inline constexpr float kStructureRangeM = 30, kStructureRangeOutdoorsM = 60;
inline constexpr double kStructureCellM = 0.5, kStructureCellOutdoorsM = 1.0;
// The weight of something in seen free space against agreement.
inline constexpr float kStructureFreeWeight = 0.5f;
// Candidates at the most, and the share of the best one's score that each must have: in the tuned
// pairs the right one had 0.5 and more.
inline constexpr size_t kStructureCandidates = 12;
inline constexpr double kMinStructureShare = 0.5;

// Storeys.

// Metres between floors at least; share of all that is level and faces up that a floor must have;
// bins of kStructureLayerM over the lowest floor, 30 m. Smaller shares take tables for floors,
// which costs time, larger ones miss a storey that was only looked into.
inline constexpr float kMinStoreyM = 2.2f;
inline constexpr double kMinStoreyShare = 0.05;
inline constexpr int kStoreyBins = 120;
// Metres within which a first look takes surfaces for met, a guess being off by a cell and by half
// a step of yaw; and the share of the best storey's overlap from which another one is tried too.
inline constexpr double kFirstLookM = 0.7, kMinStoreyOverlap = 0.7;
// Storeys that a plan view's guess is tried on, and heights that are looked at.
inline constexpr size_t kStoreysTried = 2, kMaxStoreyHeights = 9;

// Places.

// Rings and sectors of a descriptor, as Kim & Kim (IROS 2018): cells of 3 m by 6 degrees.
inline constexpr int kPlaceRings = 20, kPlaceSectors = 60;
// Places whose descriptors are compared, at least, and per place asked for: those whose ring keys
// are nearest. Of fewer the right one may be missing.
inline constexpr size_t kMinShortlist = 50, kShortlistPerHit = 5;
// Places of one map that each place of the other may be.
inline constexpr size_t kHitsPerPlace = 3;
// Metres that a guess from a place is off by itself: guesses nearer to a better one than that, and
// than two sectors, are that one.
inline constexpr double kGuessErrorM = 2;
inline constexpr double kSameGuessRad = 2 * (2 * std::numbers::pi / kPlaceSectors);

}  // namespace isthmus::matching
