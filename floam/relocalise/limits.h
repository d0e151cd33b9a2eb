// Limits of finding a robot again anywhere in what its session has seen.
//
// "A guess": nothing that is recorded says that another value was tried. When and where is looked,
// and what it takes to be sure, is in RelocaliserOptions and the options within it.
#pragma once

namespace isthmus::floam {

// Places (also track/recovery.cc).

// Metres within which two places are one, and radians likewise when no motion tells more. Guesses:
// cells of the search are 0.4 m.
inline constexpr double kSamePlaceM = 0.5;
inline constexpr double kSamePlaceRad = 0.1;
// Metres and radians between a place's pose and what its motion foretold. A guess: more keeps wrong
// places, less refuses a robot that brakes.
inline constexpr double kForetoldM = 0.25;
inline constexpr double kForetoldRad = 0.1;

// Views (place_check.cc, RelocaliserOptions).

// Metres; what is farther from the sensor is not compared. A guess.
inline constexpr double kViewM = 25;
// The same of the map's walls that the scan may look through. A guess, for time.
inline constexpr double kWallRangeM = 20;

// Search (pose_search.cc).

// Metres of reach by which headings are spaced at least, so that there are never too few. A guess.
inline constexpr double kMinHeadingReachM = 2;

// Following (relocaliser.cc).

// Seconds; scans farther apart break what was followed. A guess: five turns at 10 Hz.
inline constexpr double kFollowGapS = 0.5;
// A place is followed as long as it meets this share of the strict standard. A guess.
inline constexpr double kFollowedShare = 0.85;

// Rivals (relocaliser.cc): of twin rooms neither is claimed. Guesses, held by tests with twin
// rooms.

// Fractions of the best one's score, agreement and share that another place must reach.
inline constexpr double kRivalScore = 0.8;
inline constexpr double kRivalAgreement = 0.9;
inline constexpr double kRivalShare = 0.75;
// The excess of walls looked through that it may have: a factor, or a share of the walls (0.1 at
// first).
inline constexpr double kRivalThroughFactor = 3;
inline constexpr double kRivalThroughMore = 0.05;

}  // namespace isthmus::floam
