// Limits by which scans are taken for those of a spinning LiDAR, and get their rings and times.
//
// "A guess": nothing that is recorded says that another value was tried. Elevations, azimuths and
// times of the sensors that are known come from their data sheets: sensor_model.cc.
#pragma once

#include <cstddef>
#include <cstdint>

#include "core/geometry/angles.h"

namespace isthmus::floam {

// Requirements on a scan (ring_scan.h).

// Points in range, and metres that the largest side of the box around them has: less shows nothing,
// or a covered window. Guesses.
inline constexpr size_t kMinScanPoints = 100;
inline constexpr float kMinScanExtentM = 0.2F;
// Rings that a scan may name, or a saved state have: eight times those of the largest sensor known.
// Data that claims more is misread, and would cost memory by its rings.
inline constexpr int kMaxRings = 1024;
// Seconds before the END that a point's time may lie: no turn takes so long, and times in other
// units lie beyond. After it: what rounding of clocks makes. Guesses.
inline constexpr float kMaxScanS = 2;
inline constexpr float kClockSlackS = 1e-3F;

// Order of points (ring_order.h).

// Points of one ray are as near in time (s; a laser fires again after 20 us or more) and in
// direction (sine; a third of the finest spacing on a ring, 0.09 degrees): by the data sheets.
inline constexpr float kSameRayS = 2e-6F;
inline constexpr float kSameRaySine = 5e-4F;

// Rings from the order of points, or from elevations (ring_inference.h, ring_scan.cc).

// Turns, in the order of points, beyond which these come ring after ring: firing by firing they
// make one or, with two returns and noise, a little more; the sensors with fewest rings have eight.
inline constexpr double kRingByRingTurns = 3.5;
// Radians that elevation leaps from ring to ring at least: the densest sensors' rings are 0.1
// degrees apart and more (data sheets). Noise must stay below it.
inline constexpr float kSeamJumpRad = 0.1F * kPi / 180;
// Rings that elevations may show: twice those of the largest sensor.
inline constexpr int kMaxInferredRings = 256;
// Metres; nearer points have no clear elevation, as lasers start a few centimetres apart: by 1.5
// degrees off at most (Ouster's data sheets: 36 mm).
inline constexpr float kClearElevationM = 1.5F;
// Bins of the histogram of elevations, from straight down to straight up: a fifth of the spacing of
// the densest sensor's rings (data sheet). 0.1 degrees, tried first, cannot tell these apart.
inline constexpr int kElevationBinsPerDegree = 50;
inline constexpr float kElevationBinRad = kPi / 180 / kElevationBinsPerDegree;
inline constexpr int kElevationBins = 1 + 180 * kElevationBinsPerDegree;
// Crosstalk makes heaps of less than this share of both neighbours; a ring that shows less of
// itself than that is lost. A guess.
inline constexpr double kGhostShare = 0.25;
// Radians; the spacing that is assumed beyond the outermost ring. A guess.
inline constexpr double kOutermostSpacingRad = 0.1;
// Mean distance to the nearest ring, in spacings; 0.25 for points that know nothing of the rings
// (arithmetic). Better than the first, a model's elevations are kept; worse than the second, there
// are no rings. Guesses; tests hold both for all known sensors.
inline constexpr double kGoodRingFit = 0.1;
inline constexpr double kMaxRingMisfit = 0.18;
// Scans that show all rings there are, those that look into the sky too. A guess.
inline constexpr uint64_t kHistogramScans = 32;
// Points that the search for the beams' origin looks at (50 ms), and by what factor elevations must
// be sharper there to be believed. Guesses; tests hold them for Ouster's sensors.
inline constexpr size_t kOriginSample = 20'000;
inline constexpr double kClearlySharper = 1.1;

// Bands of elevation where there are no rings (ring_scan.h): radians of height. A guess.
inline constexpr float kBandRad = 2 * kDegree;

// The test for points in rings (scan_pattern.h).

// Points that a ring must have to be asked. A guess.
inline constexpr uint32_t kMinRingPoints = 20;
// Radians; farther apart in azimuth are no neighbours. A guess.
inline constexpr float kRingNeighbourRad = 3 * kDegree;
// Radians, median change of elevation between neighbours: noise of real sensors makes 0.03 degrees,
// a pattern that does not repeat several. In between, a guess.
inline constexpr float kMaxRingJumpRad = 0.4F * kDegree;
// Excess of elevations over those of the named sensor (radians) before a warning of another one,
// and the share of points at either end that is not looked at. Guesses.
inline constexpr float kElevationSlackRad = 3 * kDegree;
inline constexpr float kOutlyingShare = 0.01F;

// Times by the stamps of scans (azimuth_clock.h).

// Intervals of which the median counts, from a third of them on. A guess.
inline constexpr size_t kTurnIntervals = 9;
// Seconds between scans that may be a turn: sensors turn at 5 to 20 Hz (data sheets).
inline constexpr double kShortestTurnS = 0.02;
inline constexpr double kLongestTurnS = 0.6;
// Share by which an interval may differ from the period: stamps jitter less, and a scan that was
// dropped adds a whole one.
inline constexpr double kUnlikePeriod = 0.25;

// Times by azimuth (azimuth_clock.h).

// Radians; farther apart, points that follow each other in a ring do not tell the sense of turning.
inline constexpr float kTurningStepRad = 30 * kDegree;
// Share of all steps that leads forward at least: half of it does where two returns interleave.
inline constexpr float kMinForwardShare = 0.25F;
// Turns that a point may lie behind those before it, and at the start, where that may be the very
// end as well: lasers look a little to the side of each other. Guesses.
inline constexpr float kAsideTurns = 0.1F;
inline constexpr float kAsideAtStartTurns = 0.04F;
// Weight of a point in the fading average of progress, where rings are told together. A guess.
inline constexpr float kProgressFading = 1.F / 32;
// A ring is full with this share of the points of the fullest; a scan is whole with this share of a
// turn; and what whole scans make fades as slowly. Guesses.
inline constexpr float kFullRingShare = 0.8F;
inline constexpr float kWholeTurnShare = 0.9F;
inline constexpr float kWholeTurnFading = 0.99F;

}  // namespace isthmus::floam
