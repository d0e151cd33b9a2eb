// The rings of an organised cloud without a field that names them: its rows, or its columns.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "core/scan.h"

namespace isthmus::codec {

// True if a point is a measurement: finite, 1 mm to 100 km away.
bool IsReturn(const ScanPoint& p);

struct RingLines {
  bool are_rows = false;  // Else columns.
  uint32_t count = 0;     // Number of rings.

  uint16_t RingOf(uint64_t point, uint32_t width) const {
    return static_cast<uint16_t>(are_rows ? point / width : point % width);
  }
};

// Drivers store clouds row by row (height: the lasers) or firing by firing (height: the firings of
// a turn), so the directions of points tell which lines are rings. Points of a ring lie on a cone
// about the sensor's axis, whichever way that stands: their directions in one plane, in which they
// are far narrower than those of all points. A firing's do as well, and those of a sector of the
// turn nearly, but a ring sweeps as much as all.
//
// `points` are all of the cloud, row by row, those that are no returns too. Empty where neither
// rows nor columns are rings, or too few returns tell.
std::optional<RingLines> FindRingLines(uint32_t width, uint32_t height,
                                       const std::vector<ScanPoint>& points);

}  // namespace isthmus::codec
