// Units of time in nanoseconds.
#pragma once

#include <cstdint>

namespace isthmus {

inline constexpr int64_t kNsPerSecond = 1'000'000'000;      // Math.
inline constexpr int64_t kNsPerHour = 3600 * kNsPerSecond;  // Math.

}  // namespace isthmus
