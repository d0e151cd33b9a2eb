// Records as rows of numbers.
#pragma once

#include <absl/status/statusor.h>

#include <string>

#include "core/formats/pcd_header.h"
#include "core/point_payload.h"

namespace isthmus::formats {

// The rows behind the header as packed records of header.Stride() bytes, 8-byte integers already as
// float64. Rows behind those that the header announces are not read; a value that its field cannot
// hold is as StoreNumber (number_text.h) leaves it. InvalidArgument, naming the row, for too few
// rows, too few or too many values in one, and for an x, y or z that is no number.
absl::StatusOr<std::string> ParsePcdRows(const std::string& bytes, const PcdHeader& header);

// Appends one value, in the fewest digits that read back the same.
void AppendValue(const char* value, ScalarType type, std::string& text);

}  // namespace isthmus::formats
