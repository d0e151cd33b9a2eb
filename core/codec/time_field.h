// The times of a cloud's points, as its driver wrote them.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/point_payload.h"

namespace isthmus::codec {

struct TimeField {
  std::string name;  // "t", or "timestampSec + timestampNsec".
  ScalarType type = ScalarType::kFloat64;
  double unit_s = 0;  // Seconds per unit, where the name tells; else 0.
  std::vector<double> values;
};

// The times of all points of a raw payload whose layout was checked, by the first of these names
// that there is, whatever the case of its letters:
//   time, t, timestamp, time_stamp, offset_time, timeoffset, time_offset, relative_time,
//   point_time, ts            in any unit
//   time_offset_ns            nanoseconds
//   timestampSec              seconds, with those behind the point in timestampNsec (ns)
//   curvature                 milliseconds, as front ends of FAST-LIO write them, if the values
//                             span a turn: those of surfaces are below 1
// Empty where there is none.
std::optional<TimeField> ReadTimeField(const PointPayload& raw);

// True where there is such a field, and all that is in it is 0.
bool HasEmptyTimes(const PointPayload& raw);

// Makes the time of every point of a raw payload 0, in a field of its own where there is none:
// that says that the cloud is motion-compensated already.
void ClearTimes(PointPayload& raw);

// Leaves a raw payload without times, whatever the name of their field.
void DropTimes(PointPayload& raw);

}  // namespace isthmus::codec
