// Numbers as text, read for a field of some type.
#pragma once

#include <absl/strings/string_view.h>

#include <optional>

#include "core/point_payload.h"

namespace isthmus::formats {

// The whole word as a number; a plus may come before it. A number too small for a double is 0.
std::optional<double> ParseNumber(absl::string_view word);

// Stores the word as a value of the type: "4.0" is an integer too, and 1e-50 a float32, which is 0.
// False where it is no number or the type cannot hold it: then the value stored says so, NaN for a
// floating point type, 0 for an integer.
bool StoreNumber(absl::string_view word, ScalarType type, char* out);

}  // namespace isthmus::formats
