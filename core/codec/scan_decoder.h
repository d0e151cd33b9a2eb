// From a cloud as it travels to a scan as the odometry sees it.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>

#include "core/point_payload.h"
#include "core/scan.h"

namespace isthmus::codec {

// Reads a raw or quantised payload. Fields are found by name, of any scalar type:
//   x y z                    metres, required
//   intensity                or i, reflectivity, signal
//   ring                     or channel, line, row, laser_id
//   time                     or t, timestamp, time_stamp, offset_time, timeOffset
// Without a ring field the row of an organised cloud (height > 1) is the ring. Rings that count
// from the highest laser down (Ouster) are turned round, so that ring 0 is the lowest.
//
// Times may be relative or absolute, in s, ms, us or ns: one turn takes 0.02 to 0.5 s, which only
// one of these units explains. A shorter span is taken as ns in an integer field and as s in a
// floating-point one. They become seconds relative to the scan's END, the latest being 0; where no
// unit fits, or a time is not finite, has_time stays false.
//
// No-returns (NaN, infinite, nearer than 1 mm or farther than 100 km) are dropped, order is kept.
// InvalidArgument, naming what is wrong, for a layout that does not fit its data (see
// CheckLayout), missing x y z, damaged compression, a ring outside [0, 65535], and for a scan
// without any return.
absl::StatusOr<Scan> DecodeScan(const PointPayload& payload, uint64_t sequence,
                                int64_t end_stamp_ns);

}  // namespace isthmus::codec
