// Limits of keeping maps to be found in.
#pragma once

namespace isthmus::localisation {

// Seconds between makings of a map that changes, and times what making it takes, of which more is
// waited: robots that map must not be slowed down by those that are found. Guesses.
inline constexpr double kLeastAgeS = 10;
inline constexpr double kLeastAgeMakings = 20;

}  // namespace isthmus::localisation
