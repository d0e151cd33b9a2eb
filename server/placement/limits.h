// Limits of placement beside PlacerOptions: the weight of edges by hand and anchors, and the least
// that counts as moved, as changed or as something.
//
// A number without a source is a guess that was never varied by itself. All of them together were
// in view on mapping_benchmark (lab/docs/mapping.md); decision 0011 has the reasons.
#pragma once

#include <cstddef>

#include "core/geometry/angles.h"

namespace isthmus::placement {

// Standard deviations, metres and radians, of a match that a person gave, and of one that was
// computed and has lost its submaps since. Too small, a careless hand bends the map.
inline constexpr double kByHandM = 0.05, kByHandRad = 0.5 * kRadPerDeg;
inline constexpr double kWeakM = 0.3, kWeakRad = 2 * kRadPerDeg;
// Metres, per axis: farther away doubles hold no more than a hundredth of a micrometre. A pose
// there is no place.
inline constexpr double kMaxTranslationM = 1e8;

// Metres, and over pose_graph::kLeverM radians: a match that differs by less from the one before it
// was refined, which makes the one before no mistake to be undone.
inline constexpr double kRefinedM = 0.5;
// Metres, and over pose_graph::kLeverM radians: submaps beside what is optimised that want to move
// by less stay. A fifth of the default: chains of submaps are soft, and what each of them keeps of
// a bend adds up.
inline constexpr double kRestM = 1e-4;
// Sum of squared errors below which it is rounding, and nothing is optimised.
inline constexpr double kNothingCost = 1e-9;
// Matches that can be taken back without a trace, latest first, by what is kept of the map before
// each: memory. Older ones are taken back by beginning anew.
inline constexpr size_t kMaxEarlier = 8;
// Edges that are asked about one transform of the initial poses. Time.
inline constexpr size_t kMaxEdgesAsked = 64;

// Anchors.

// Anchors from which on one may be wrong: the others outvote it.
inline constexpr size_t kAnchorsToDoubt = 4;
// Anchors of which all pairs are tried for a first transform. Time grows with the square.
inline constexpr size_t kMaxAnchorsInPairs = 40;
// Metres between two positions that are to give a heading: nearer ones are the same.
inline constexpr double kMinBaselineM = 1e-3;
// Standard deviation, radians, of the vertical of the reference's odometry where anchors give none.
// Larger, an optimiser tilts the map to make it a percent shorter (decision 0011).
inline constexpr double kVerticalRad = 2 * kRadPerDeg;

}  // namespace isthmus::placement
