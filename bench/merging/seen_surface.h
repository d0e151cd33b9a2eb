// How much of the world two robots have in common, as a function of how long they drove.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <unordered_map>
#include <vector>

#include "bench/merging/driven_robot.h"

namespace isthmus::bench {

// Cells of the world's surface, with the scan that first saw each: from the submaps' points, where
// their keyframes were in truth. Immutable.
class SeenSurface {
 public:
  explicit SeenSurface(const DrivenRobot& robot);

  // Share of the cells of the one that saw fewer which the other saw too, [0, 1]: if both robots
  // had stopped after their scan `sequence`.
  static double Overlap(const SeenSurface& a, const SeenSurface& b, uint64_t sequence = UINT64_MAX);

 private:
  std::unordered_map<uint64_t, uint64_t> first_seen_;  // Sequence by cell.
};

// In [0, 1].
struct OverlapRange {
  double least = 0, most = 1;
};

// The last scan after which both robots can stop such that their overlap is in the range; nothing
// if there is none. Looks at every tenth scan.
std::optional<uint64_t> FindStop(const DrivenRobot& a, const DrivenRobot& b,
                                 const OverlapRange& range);

// As if the robot had stopped after that scan: what it saw later is gone. At least its first
// keyframe stays.
void StopAfter(uint64_t sequence, DrivenRobot* robot);

}  // namespace isthmus::bench
