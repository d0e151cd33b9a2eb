// The hypotheses that each search makes of a pair, and whether they are right: what a model of
// confidence is fitted to, and which search finds what.
#pragma once

#include <string>
#include <vector>

#include "lab/bench/merging/driven_robot.h"
#include "lab/bench/merging/judge.h"
#include "server/matching/pairs/hypothesis.h"

namespace isthmus::bench {

struct JudgedHypothesis {
  matching::Hypothesis rigid, joint;  // Before and after its joint refinement, if it had one.
  bool is_joint = false;
  bool right = false;        // Rigid within 1 m and 3 degrees, drift apart.
  bool joint_right = false;  // Joint within 0.3 m and 1 degree, drift apart.
  MapError error;            // Rigid, by the truth.
};

struct JudgedPair {
  std::string scenario;
  uint64_t seed = 0;
  double overlap = 0;  // By the truth.
  // Fit of the map on itself elsewhere, 1 being in place: high in a world that repeats.
  double repeats_a = 0, repeats_b = 0;
  std::vector<JudgedHypothesis> hypotheses = {};
};

// All that the searches propose, each search by itself; those that look best are refined jointly,
// as the matcher does, and what leads to the same place is one.
JudgedPair JudgeHypotheses(std::vector<DrivenRobot> robots);

// Markdown: in how many pairs each search finds the right place, and which it alone finds.
std::string SearchTable(const std::vector<JudgedPair>& pairs);

// A line per hypothesis, with a heading.
std::string ToCsv(const std::vector<JudgedPair>& pairs);

}  // namespace isthmus::bench
