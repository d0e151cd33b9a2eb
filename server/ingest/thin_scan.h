// A scan of more points than the odometry needs, thinned.
#pragma once

#include <cstddef>

#include "core/scan.h"

namespace isthmus::ingest {

// Keeps about `most` points of a scan that has more, in their order: spread evenly over the scan,
// by a rule that fits no pattern of rings or firings, and the same every time. Scans that have no
// more are left as they are.
void ThinScan(size_t most, Scan* scan);

}  // namespace isthmus::ingest
