// Limits of asking robots for drives. All are guesses but where it is said.
#pragma once

#include <cstddef>

namespace isthmus::matching {

// Ways.

// Stops of either map: views a metre apart, fewer on ways that are longer.
inline constexpr size_t kMaxStops = 1000;
// Metres that a robot may leave a driven way for, where it can see that nothing stands between; on
// its own ways, and to the other's.
inline constexpr double kShortcutM = 6, kCrossingM = 15;
// Metres of a driven way that are as easy as one where nobody has driven: chairs stand lower than
// sensors look.
inline constexpr double kUndriven = 3;
// Metres by which what is measured has to lie behind, and between the heights of two sensors: of
// another robot, or of this one on a slope.
inline constexpr float kClearM = 0.5f;
inline constexpr double kMaxRiseM = 2;

// Ground.

// Metres from where a robot was, within which it has seen what is to be seen.
inline constexpr double kBeenThereM = 4;
// Metres: cells; the distance up to which ground counts as seen well, where things on it are told
// from each other, and outdoors; and radians between directions, a cell at that distance.
inline constexpr double kAskedCellM = 1, kSeenWellM = 12, kSeenWellOutdoorsM = 30;
inline constexpr double kAskedStepRad = 0.035;

// Forecasts.

// Square metres below which the counts of shared ground are no rule for more of it.
inline constexpr double kLeastKnownM2 = 30;
// Share of what the other robot saw along a stretch that counts: who drives there sees not all of
// it again. Wild pairs of seeds 11000 to 11025 were in view when it was chosen.
inline constexpr double kSeenAgain = 0.5;
// Hypotheses that are asked about, the probability that each must have, and that it must have after
// the drive if it is right; and the share of the doubt that may be left then.
inline constexpr size_t kMaxAsked = 3;
inline constexpr double kLeastProbability = 0.05, kLeastAfterwards = 0.5, kDoubtLeft = 0.6;
// Metres of the longest drive that is asked for.
inline constexpr double kFarthestM = 300;
// Metres that a drive costs before it begins: a robot is asked for one drive rather than for two.
inline constexpr double kDriveBeginsM = 10;

}  // namespace isthmus::matching
