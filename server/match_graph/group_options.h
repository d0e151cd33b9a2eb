// Limits within which sessions settle each other's open matches.
#pragma once

#include <cstddef>

#include "server/match_graph/cycle_options.h"

namespace isthmus::match_graph {

struct GroupOptions {
  // Within which hypotheses agree, and what is the same ground. Half of what accepted matches may
  // be off beside drift: what is set aside must be clearly off, what is accepted clearly on.
  CycleOptions cycles = {.max_m = 0.5, .max_deg = 2};
  // Probability with which what is settled must be right; wrong on the low side, maps are merged
  // that do not belong together.
  double min_probability = 0.99;
  // That a wrong hypothesis agrees with others by chance: of places as large as what cycles leave
  // open there are thousands in a map, but what repeats (racks, rooms, rows of trees) leaves few to
  // choose from.
  double chance = 0.02;
  double min_confidence = 0.05;  // Hypotheses of less say nothing.
  // Bounds of time: the most confident so many hypotheses between two frames, and ways round three
  // frames that are looked at.
  size_t max_between = 32, max_triples = 200'000;
};

}  // namespace isthmus::match_graph
