// Limits within which sessions settle each other's open matches.
#pragma once

#include <cstddef>

#include "server/match_graph/cycle_options.h"

namespace isthmus::match_graph {

struct GroupOptions {
  // Limits within which hypotheses agree and ground is the same. Half of the error that accepted
  // matches may have beside drift: a match that is set aside must be clearly off, an accepted one
  // clearly on.
  CycleOptions cycles = {.max_m = 0.5, .max_deg = 2};
  // Probability with which a settled match must be right; wrong on the low side, maps are merged
  // that do not belong together.
  double min_probability = 0.99;
  // Probability that a wrong hypothesis agrees with others by chance: there are thousands of places
  // in a map as large as cycles leave open, but repetition (racks, rooms, rows of trees) leaves few
  // to choose from.
  double chance = 0.02;
  double min_confidence = 0.05;  // Hypotheses of less say nothing.
  // Bounds of time: the most confident so many hypotheses between two frames, and ways round three
  // frames that are looked at.
  size_t max_between = 32, max_triples = 200'000;
};

}  // namespace isthmus::match_graph
