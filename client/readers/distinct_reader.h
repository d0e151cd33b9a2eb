// A reader without the scans that a recording holds twice.
#pragma once

#include <memory>

#include "client/readers/scan_reader.h"

namespace isthmus::readers {

// The scans of another reader but for those whose stamp and bytes are those of one of the few
// before (kDistinctScans): a topic that was recorded twice, or recordings joined with themselves.
// How many were left out is among the assumptions.
std::unique_ptr<ScanReader> LeaveOutTwins(std::unique_ptr<ScanReader> reader);

}  // namespace isthmus::readers
