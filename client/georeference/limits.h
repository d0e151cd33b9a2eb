// Limits of what fixes of a GNSS receiver are believed.
#pragma once

#include <cstddef>

namespace isthmus::georeference {

// Standard deviations of a fix that states none, metres: of a receiver without corrections under an
// open sky. Smaller ones would bend maps that odometry has right.
inline constexpr double kUnknownSigmaXyM = 5, kUnknownSigmaZM = 10;
// Metres below which no fix is believed: what antennas are mounted off, and clocks are, by.
inline constexpr double kLeastSigmaM = 0.02;
// Seconds between two fixes across which the way is taken to be straight. Receivers give 1 to 20
// fixes a second; after a gap of more a robot may have turned.
inline constexpr double kLongestGapS = 2;
// Metres per second that a robot may go where only one fix is near: what its sigma grows by. A
// walking person; faster ones lose little, as fixes that are early or late are the exception.
inline constexpr double kDriftMps = 1.5;

// Most bend of a way, per metre from its middle: odometry that drifts by 3 % is poor.
inline constexpr double kWayDrift = 0.03;
// Times its sigma and drift by which a place may miss the way: beyond the first it counts less and
// less (2.385 loses 5 % on normal errors), beyond the second its fix is wild.
inline constexpr double kOddSigmas = 2.385, kWildSigmas = 6;
// Places from which on odd ones can be told, and how often weights are made anew.
inline constexpr size_t kLeastPlaces = 4;
inline constexpr int kWayRounds = 50;

// Standard deviation, rad, of a heading that is known by how a way lies on its fixes: by how much
// odometry may have turned since. A guess: 3 degrees. Above the most a heading is not known at all.
inline constexpr double kHeadingDriftRad = 0.05, kMostHeadingSigmaRad = 0.35;

}  // namespace isthmus::georeference
