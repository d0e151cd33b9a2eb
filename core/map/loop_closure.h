// A place that a session came back to, or a step in which its odometry errs; found and verified.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/ids.h"
#include "core/map/match.h"
#include "core/pose.h"

namespace isthmus {

// Numbers that were not computed stay at -1.
struct LoopClosure {
  uint64_t id = 0;  // Given by the server, from 1, ascending; 0: none yet.
  SessionId session;
  uint32_t submap_a = 0;  // Index of the older submap, ...
  uint32_t submap_b = 0;  // ... and of the newer, which lies on it.
  Pose T_a_b;             // Takes a point of the newer submap's frame to the older's.
  double confidence = 0;  // As in Match, like the following.
  double overlap = -1;
  double residual_m = -1;
  double free_space = -1;
  int64_t comparisons = -1;
  GuessSource source = GuessSource::kNone;
  std::string detail;       // One sentence for a person, with the numbers.
  int64_t computed_ns = 0;  // Unix nanoseconds.
  // Older submaps (submap_a) on newer ones (submap_b) of the session, that pair among them; at
  // least one.
  std::vector<SubmapEdge> edges;
  bool rejected = false;  // By a person: it counts for nothing until that is taken back.
  std::string note;       // Why, in the person's own words.
};

}  // namespace isthmus
