// A guess at how two maps lie on each other, before anything has been verified.
#pragma once

#include "core/map/match.h"
#include "core/pose.h"

namespace isthmus::matching {

struct Candidate {
  Pose T_a_b;        // Takes b's odom frame to a's.
  double score = 0;  // Higher is better; comparable within one source only.
  GuessSource source = GuessSource::kNone;
};

}  // namespace isthmus::matching
