// Limits of following the sensor from scan to scan, of its beginning and of finding it again
// nearby.
//
// "A guess": nothing that is recorded says that another value was tried.
#pragma once

#include <cstddef>
#include <cstdint>

namespace isthmus::floam {

// Extrapolation (tracker.cc).

// Seconds that a motion is taken to go on, and that its tilting does: a bump, or noise. Guesses.
inline constexpr double kMaxExtrapolationS = 3;
inline constexpr double kMaxTiltingS = 0.3;
// Periods between scans beyond which too much may have happened to trust the motion: three scans
// that were dropped are none. A guess.
inline constexpr double kGapPeriods = 3.5;

// Learning of the motion (tracker.cc).

// Weight of a scan in the averages of the twist: a second at 10 Hz (decisions 0016, 0017).
inline constexpr double kTwistFading = 0.1;
// In that of the acceleration: 3 s. One acceleration for all robots cost some 1.4 % of their way,
// and others 1.9 % (decision 0017).
inline constexpr double kAccelerationFading = 0.03;
// Nanoseconds after a direction was not observed in which speed goes on as steadily as this robot
// drove, and scans are matched to the one before: after one scan of it, ten times as many were lost
// (decisions 0017, 0018).
inline constexpr int64_t kSteadyNs = 1'000'000'000;

// Belief in a match (tracker.cc).

// Sigma of a place about which little is known, m and rad. A guess.
inline constexpr double kNearM = 2;
inline constexpr double kNearRad = 0.5;
// Chi squared with six degrees of freedom: 99.9 %.
inline constexpr double kMostSurprise2 = 22.5;

// The beginning (start.cc).

// Times that motion and map of the first two scans follow from each other, and more times that
// these two alone are matched. Guesses.
inline constexpr int kStartIterations = 4;
inline constexpr int kMotionRepeats = 2;
// Sigma of the first motion about each that it begins from, per scan, m and rad. A guess: 3 m/s.
inline constexpr double kAnyMotionM = 0.3;
inline constexpr double kAnyMotionRad = 0.15;
// Motions that are one, m and rad. A guess.
inline constexpr double kSameMotionM = 0.05;
inline constexpr double kSameMotionRad = 0.01;

// The cost of a lost robot (recovery.cc): not more than others, measured by the benchmark's lost
// scans in its scenarios "covered" and "elsewhere". More finds robots sooner.

// The first scans that are lost are searched at once, later ones now and then.
inline constexpr int kEagerSearches = 2;
inline constexpr int kSearchSpacing = 5;
// Every guess is looked at with a few features and a wide loss, the best tenth with four times as
// many, ...
inline constexpr size_t kGuessesPerScan = 2000;
inline constexpr size_t kGlancePoints = 30;
inline constexpr double kGlanceKernelM = 0.4;  // Wider than half a step of the grid; 0.5 at first.
// ... and the best that are not near each other are matched properly: so many a little, the better
// ones twice as long. 8 iterations and more tries were slower.
inline constexpr size_t kFirstTries = 10;
inline constexpr size_t kBetterTries = 4;
inline constexpr int kTryIterations = 3;

// Belief in a place nearby (recovery.cc); metres as kSamePlaceM.

// Radians within which guesses are one: less than a step of the grid. A guess.
inline constexpr double kDistinctRad = 0.12;
// A match elsewhere that scores at least this share of the best makes it ambiguous. A guess.
inline constexpr double kAmbiguousScore = 0.93;
// So far (m) from the last place seen a good part of what is seen may be new, if it drove there;
// not after so many seconds (108 robots that were kidnapped, decision 0018).
inline constexpr double kEdgeM = 4;
inline constexpr double kEdgeS = 4;

// Places looked at (recovery_guesses.cc). Guesses, but for the steps.

// Arcs: seconds and radians at most, their steps (rad), and how much it may have sped up.
inline constexpr double kMaxArcS = 6;
inline constexpr double kMaxArcRad = 1.6;
inline constexpr double kArcStepRad = 0.1;
inline constexpr double kArcReach = 1.1;
// rad/s that the heading may be off by (0.6 at first); two steps of the grid at least.
inline constexpr double kGuessRadPerS = 0.8;
// Metres that the grid reaches at most; one step of it, and the last speed's way, at least.
inline constexpr double kMaxGridM = 2.5;
// Steps of the grid, m and rad: matching converges from half of both.
inline constexpr double kGridM = 0.6;
inline constexpr double kGridRad = 0.15;

}  // namespace isthmus::floam
