// Rings of scans whose points do not name theirs.
#pragma once

#include <cstdint>
#include <vector>

#include "core/scan.h"

namespace isthmus::floam {

// For scans that hold one ring after the other (KITTI's HDL-64 files): a new ring starts where the
// azimuth completes a turn. `turns` is the signed number of turns in the order of points. Fills
// `*rings`; returns their number.
int RingsByWrap(const std::vector<float>& azimuths, double turns, std::vector<uint16_t>* rings);

// The elevations (radians, ascending) around which the points of `scan` gather: the peaks of a
// histogram. At most 256; empty when the points do not lie in rings.
std::vector<double> FindElevations(const Scan& scan);

// Gives every point the ring of nearest elevation. `elevations` is ascending and not empty. Returns
// the mean distance to it in units of the spacing of the rings there: about 0.25 for points that
// know nothing of these rings, near 0 for points of this sensor.
double RingsByElevation(const Scan& scan, const std::vector<double>& elevations,
                        std::vector<uint16_t>* rings);

}  // namespace isthmus::floam
