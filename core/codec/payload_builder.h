// Raw payloads from the clouds that algorithms use.
#pragma once

#include <vector>

#include "core/cloud.h"
#include "core/point_payload.h"
#include "core/scan.h"

namespace isthmus::codec {

// Fields x y z intensity (float32) [ring (uint16)] [time (float32, seconds)], packed. DecodeScan
// gives the same points back.
PointPayload MakePayload(const std::vector<ScanPoint>& points, bool has_ring, bool has_time);
PointPayload MakePayload(const Scan& scan);

// Fields x y z intensity (float32).
PointPayload MakePayload(const Cloud& cloud);

}  // namespace isthmus::codec
