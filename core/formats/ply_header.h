// The text in front of a PLY file's data.
#pragma once

#include <absl/status/statusor.h>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/point_payload.h"

namespace isthmus::formats {

enum class PlyEncoding : uint8_t { kAscii, kLittle, kBig };

// A number as a binary PLY file has it. 8-byte integers, which a payload has no type for, are read
// as float64.
struct PlyType {
  ScalarType type = ScalarType::kFloat32;  // Type of the value read.
  uint32_t size = 4;                       // Bytes in the file; 0: the type is not known.
  bool is_wide_signed = false, is_wide_unsigned = false;  // 8-byte integers.
};

struct PlyProperty {
  std::string name;             // As UnderstandColumn (field_names.h) has it.
  PlyType type;                 // Type of the value, or of a list's values.
  std::optional<PlyType> list;  // The type of the number of values; none: it is no list.
};

struct PlyElement {
  std::string name;
  uint64_t count = 0;
  std::vector<PlyProperty> properties;

  // Bytes of one in a binary file with lists that are empty; the least that one takes.
  uint64_t LeastBytes() const;
};

struct PlyHeader {
  PlyEncoding encoding = PlyEncoding::kAscii;
  std::vector<PlyElement> elements;  // In the order of the data, up to "vertex".
  size_t data_start = 0;

  const PlyElement& vertex() const { return elements.back(); }
};

// InvalidArgument, naming what is wrong, for a header that does not end, has no element "vertex" or
// names what cannot be passed over: in a binary file, a type that is not known.
absl::StatusOr<PlyHeader> ParsePlyHeader(const std::string& bytes);

// "PLY: why".
absl::Status BadPly(const std::string& why);

}  // namespace isthmus::formats
