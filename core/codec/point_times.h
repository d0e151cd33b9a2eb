// The unit of a scan's time field, which drivers leave to guesswork.
#pragma once

#include <vector>

#include "core/point_payload.h"

namespace isthmus::codec {

// Seconds per unit of a time field whose values within one scan span `span` units; 0 when no unit
// makes sense. See DecodeScan for the rule.
double SecondsPerUnit(ScalarType type, double span);

// Turns raw times into seconds relative to the latest. False, and `times` left as it is, when a
// time is not finite or no unit makes sense.
bool MakeRelativeToEnd(ScalarType type, std::vector<double>& times);

}  // namespace isthmus::codec
