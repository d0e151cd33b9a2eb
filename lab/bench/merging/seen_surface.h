// The surface that robots have seen, to choose drives by the share they have in common.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <unordered_map>
#include <utility>
#include <vector>

#include "lab/bench/merging/driven_robot.h"

namespace isthmus::bench {

// Scans of a drive, both ends included.
struct ScanRange {
  uint64_t first = 0, last = UINT64_MAX;
};

// Cells of the world's surface, with the scans that saw each first and last: from the submaps'
// points, where their keyframes were in truth. Immutable.
class SeenSurface {
 public:
  explicit SeenSurface(const DrivenRobot& robot);

  // Share of the cells of the one that saw fewer which the other saw too, [0, 1]; if all had been
  // seen in these stretches. Stretches begin with a drive's first scan or end with its last.
  static double Overlap(const SeenSurface& a, const SeenSurface& b, const ScanRange& of_a = {},
                        const ScanRange& of_b = {});

 private:
  static bool Contains(const ScanRange& range, const ScanRange& seen) {
    return seen.first <= range.last && seen.last >= range.first;
  }
  size_t Count(const ScanRange& range) const;

  std::unordered_map<uint64_t, ScanRange> cells_;  // When each was seen.
};

// In [0, 1].
struct OverlapRange {
  double least = 0, most = 1;
};

// The longest stretches, of as many scans for either robot, in which their overlap is in the range;
// nothing if there are none. Both are beginnings of the drives, or else `ends_too`, beginnings or
// ends. Looks at every tenth length.
std::optional<std::pair<ScanRange, ScanRange>> FindScanRanges(const DrivenRobot& a,
                                                              const DrivenRobot& b,
                                                              const OverlapRange& range,
                                                              bool ends_too);

// As if the robot had driven that stretch only: submaps that begin earlier and what was seen later
// are gone. At least one keyframe stays.
void KeepScans(const ScanRange& range, DrivenRobot* robot);

}  // namespace isthmus::bench
