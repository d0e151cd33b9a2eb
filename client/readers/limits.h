// Limits by which recordings are read.
#pragma once

#include <cstddef>

namespace isthmus::readers {

// Errors that are read over in search of a first scan, before a recording is taken to tell nothing
// of its sensor. A guess; all are kept.
inline constexpr size_t kErrorsReadAhead = 100;

}  // namespace isthmus::readers
