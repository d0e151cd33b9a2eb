// The processor time of matching one pair: its first search, and every submap more while it waits.
#pragma once

#include <string>
#include <vector>

#include "core/map/match.h"
#include "lab/bench/merging/driven_robot.h"

namespace isthmus::bench {

struct PairCost {
  std::string scenario;
  size_t submaps = 0;   // Both robots', at the first search.
  double across_m = 0;  // The longer side of the larger map's way, level.
  double first_s = 0;   // The first search, with what is made of the maps for it.
  uint32_t candidates = 0;
  std::vector<StageTime> stages;  // Wall times of the first search.
  std::vector<double> waiting_s;  // Each submap that came after that.
};

// Searches the pair of whole maps but for the last `later` submaps of each robot, which then come
// one by one and in turn. Nothing is accepted, so that the pair waits. `robots` are two, whose
// submaps are prepared first: this is not counted.
PairCost MeasurePairCost(std::vector<DrivenRobot> robots, size_t later);

// Markdown, a row per scenario; and what the stages of the first searches took.
std::string PairCostTable(const std::vector<PairCost>& costs);

}  // namespace isthmus::bench
