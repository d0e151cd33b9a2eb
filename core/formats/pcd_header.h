// The text in front of a PCD file's data.
#pragma once

#include <absl/status/statusor.h>

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "core/formats/pcd.h"
#include "core/point_payload.h"
#include "core/pose.h"

namespace isthmus::formats {

struct PcdField {
  std::string name;    // "_" is padding.
  char kind = 'F';     // I, U or F.
  uint32_t size = 4;   // Bytes of one value: 1, 2, 4 or 8.
  uint32_t count = 1;  // Values per point.

  uint32_t Bytes() const { return size * count; }
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

// InvalidArgument unless every needed line is there once, is well formed and agrees with the
// others.
absl::StatusOr<PcdHeader> ParsePcdHeader(const std::string& bytes);

// `comments` come first, one line each, without the leading #.
std::string FormatPcdHeader(const PcdHeader& header, const std::vector<std::string>& comments = {});

// The kind and size that `type` has in a PCD file.
PcdField ToPcdField(const std::string& name, ScalarType type, uint32_t count);
// The type of a PCD field; InvalidArgument for a kind and size that do not exist. 8-byte integers
// are given as kFloat64.
absl::StatusOr<ScalarType> ToScalarType(const PcdField& field);

}  // namespace isthmus::formats
