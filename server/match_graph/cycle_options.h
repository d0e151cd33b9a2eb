// Limits within which matches round a cycle agree.
#pragma once

#include <cstddef>

namespace isthmus::match_graph {

// Going round a cycle of true matches leaves nothing but what the matches are off and what the
// robots' odometry drifted: each match lays whole maps on each other and is right where the two
// robots met, so between the place where a robot met one and that where it met the other its own
// drift comes in. Drift grows with the size of the map; those of several maps add up at random.
struct CycleOptions {
  double max_m = 1.0;    // Allowed besides drift,
  double drift = 0.01;   // and this share of each map's extent, summed in squares.
  double max_deg = 3.0;  // Allowed round a triangle; grows with the square root of the length.
  // If several matches might be the wrong one, only the least certain is set aside if its odds are
  // so many times less than any other's; else all of them are.
  double min_odds = 10;
  // A match might be the wrong one as well as another if its share of agreeing cycles is less than
  // so many times the other's.
  double min_support = 2;
  // Matches of a session rest on the same ground where its submaps that they rest on are nearer to
  // each other than so many metres (what a robot sees of a room at least), by this share of those
  // of the one that has fewer. They are then wrong together, as in a room that has a twin, and
  // count once. Guesses, never varied.
  double ground_m = 15;
  double max_same_ground = 0.5;
  // Bounds of time and memory. Beyond, only the cycles that the spanning forest closes are looked
  // at (triangles), or triangles and those (squares): in so dense a graph they are enough.
  size_t max_triangles = 100'000, max_squares = 10'000;
};

}  // namespace isthmus::match_graph
