// Files of times: when each scan of a folder was taken.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <string>
#include <vector>

namespace isthmus::readers {

// Seconds, one per line, plain (kept to the nanosecond) or in scientific notation, or dates as
// KITTI's raw drives have them ("2011-09-26 13:02:25.951199337", taken for UTC), as nanoseconds.
// Empty lines are skipped. Times may go back, where a clock was set: ScanClock tells wherever scans
// are used. InvalidArgument, naming the line, for anything else.
absl::StatusOr<std::vector<int64_t>> ParseTimes(const std::string& text);

}  // namespace isthmus::readers
