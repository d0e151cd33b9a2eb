// The text in front of a PCD file's data.
#pragma once

#include <absl/status/statusor.h>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/formats/pcd.h"
#include "core/point_payload.h"
#include "core/pose.h"

namespace isthmus::formats {

struct PcdField {
  std::string name;    // "_" is padding.
  char kind = 'F';     // I, U or F.
  uint32_t size = 4;   // Bytes of one value.
  uint32_t count = 1;  // Values per point.

  uint32_t Bytes() const { return size * count; }
  bool IsPadding() const { return name == "_"; }
};

struct PcdHeader {
  std::vector<PcdField> fields;
  uint32_t width = 0;
  uint32_t height = 1;
  Pose viewpoint;
  PcdEncoding encoding = PcdEncoding::kBinary;
  size_t data_start = 0;  // Byte of the file where the data begins.

  uint64_t Points() const { return uint64_t{width} * height; }
  uint32_t Stride() const;
};

// Lines that others imply may be missing: SIZE, TYPE and COUNT are 4, F and 1 then, as in version
// 0.5; without WIDTH and HEIGHT, or where their product is 0, POINTS tells. A VIEWPOINT
// that is no pose and lines of other keys are passed over. InvalidArgument unless the rest is there
// once, is well formed and does not contradict itself, x, y and z have values, and a point bytes.
absl::StatusOr<PcdHeader> ParsePcdHeader(const std::string& bytes);

// `comments` come first, one line each, without the leading #.
std::string FormatPcdHeader(const PcdHeader& header, const std::vector<std::string>& comments = {});

// The kind and size that `type` has in a PCD file.
PcdField ToPcdField(const std::string& name, ScalarType type, uint32_t count);
// The type of a PCD field's values, kFloat64 for 8-byte integers. None for what a payload has no
// field for: padding, no values, or a kind and size that are not known.
std::optional<ScalarType> ToScalarType(const PcdField& field);

}  // namespace isthmus::formats
