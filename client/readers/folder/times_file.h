// times.txt: when each scan of a folder ended.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <string>
#include <vector>

namespace isthmus::readers {

// Seconds, one per line, plain (kept to the nanosecond) or in scientific notation, as nanoseconds.
// Empty lines are skipped. InvalidArgument, naming the line, for anything else and for a stamp that
// is not later than the one before.
absl::StatusOr<std::vector<int64_t>> ParseTimes(const std::string& text);

}  // namespace isthmus::readers
