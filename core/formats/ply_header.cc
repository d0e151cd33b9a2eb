#include "core/formats/ply_header.h"

#include <absl/strings/match.h>
#include <absl/strings/numbers.h>
#include <absl/strings/str_cat.h>
#include <absl/strings/str_split.h>
#include <absl/strings/string_view.h>

#include <limits>
#include <utility>

#include "core/formats/field_names.h"

namespace isthmus::formats {
namespace {

using HeaderLine = std::vector<absl::string_view>;

// The standard asks for less than a hundred.
constexpr int kMaxHeaderLines = 10'000;

PlyType TypeOf(absl::string_view name) {
  const struct {
    const char *old_name, *name;
    ScalarType type;
  } types[] = {
      {"char", "int8", ScalarType::kInt8},        {"uchar", "uint8", ScalarType::kUint8},
      {"short", "int16", ScalarType::kInt16},     {"ushort", "uint16", ScalarType::kUint16},
      {"int", "int32", ScalarType::kInt32},       {"uint", "uint32", ScalarType::kUint32},
      {"float", "float32", ScalarType::kFloat32}, {"double", "float64", ScalarType::kFloat64}};
  for (const auto& type : types) {
    if (name == type.old_name || name == type.name) return {type.type, SizeOf(type.type)};
  }
  if (name == "int64" || name == "long") return {ScalarType::kFloat64, 8, true, false};
  if (name == "uint64" || name == "ulong") return {ScalarType::kFloat64, 8, false, true};
  return {ScalarType::kFloat64, 0};
}

// Reads line by line up to end_header.
class PlyHeaderParser {
 public:
  absl::StatusOr<PlyHeader> Parse(const std::string& bytes) {
    size_t at = 0;
    for (int line = 0;; ++line) {
      const size_t end = bytes.find('\n', at);
      if (end == std::string::npos || line > kMaxHeaderLines) {
        return BadPly("the header has no end_header");
      }
      const absl::string_view text(bytes.data() + at, end - at);
      at = end + 1;
      if (line == 0) {
        if (!absl::StartsWith(text, "ply")) return BadPly("it does not begin with 'ply'");
        continue;
      }
      const HeaderLine words = absl::StrSplit(text, absl::ByAnyChar(" \t\r"), absl::SkipEmpty());
      if (words.empty()) continue;
      if (words[0] == "end_header") break;
      if (absl::Status status = TakeLine(words); !status.ok()) return status;
    }
    header_.data_start = at;
    return Checked();
  }

 private:
  absl::Status TakeLine(const HeaderLine& words) {
    if (words[0] == "format" && words.size() >= 2) return TakeFormat(words[1]);
    if (words[0] == "element" && words.size() >= 3) return AddElement(words);
    if (words[0] == "property" && is_read_) return AddProperty(words);
    return absl::OkStatus();
  }

  absl::Status TakeFormat(absl::string_view name) {
    if (name == "ascii") {
      header_.encoding = PlyEncoding::kAscii;
    } else if (name == "binary_little_endian") {
      header_.encoding = PlyEncoding::kLittle;
    } else if (name == "binary_big_endian") {
      header_.encoding = PlyEncoding::kBig;
    } else {
      return BadPly(absl::StrCat("unknown format '", name, "'"));
    }
    return absl::OkStatus();
  }

  absl::Status AddElement(const HeaderLine& words) {
    is_read_ = !has_vertices_;
    if (!is_read_) return absl::OkStatus();
    PlyElement element{std::string(words[1]), 0, {}};
    if (!absl::SimpleAtoi(words[2], &element.count)) {
      return BadPly(absl::StrCat("bad number of '", words[1], "'"));
    }
    has_vertices_ = words[1] == "vertex";
    header_.elements.push_back(std::move(element));
    return absl::OkStatus();
  }

  // "property TYPE NAME" or "property list TYPE TYPE NAME".
  absl::Status AddProperty(const HeaderLine& words) {
    const bool is_list = words.size() >= 2 && words[1] == "list";
    if (words.size() != (is_list ? 5 : 3)) return BadPly("a property is cut off");
    PlyProperty property{UnderstandColumn(words.back()).name, TypeOf(words[is_list ? 3 : 1]),
                         std::nullopt};
    if (is_list) property.list = TypeOf(words[2]);
    header_.elements.back().properties.push_back(std::move(property));
    return absl::OkStatus();
  }

  absl::StatusOr<PlyHeader> Checked() {
    if (!has_vertices_) return BadPly("there is no element 'vertex'");
    if (header_.vertex().count > std::numeric_limits<uint32_t>::max()) {
      return BadPly("too many points");
    }
    if (header_.encoding == PlyEncoding::kAscii) return std::move(header_);
    for (const PlyElement& element : header_.elements) {
      for (const PlyProperty& property : element.properties) {
        if (property.type.size > 0 && (!property.list || property.list->size > 0)) continue;
        return BadPly(absl::StrCat("'", property.name, "' has a type that is not known"));
      }
    }
    return std::move(header_);
  }

  PlyHeader header_;
  bool is_read_ = false;  // The element at hand; what is behind the points is not.
  bool has_vertices_ = false;
};

}  // namespace

uint64_t PlyElement::LeastBytes() const {
  uint64_t bytes = 0;
  for (const PlyProperty& property : properties) {
    bytes += property.list ? property.list->size : property.type.size;
  }
  return bytes;
}

absl::StatusOr<PlyHeader> ParsePlyHeader(const std::string& bytes) {
  return PlyHeaderParser().Parse(bytes);
}

absl::Status BadPly(const std::string& why) {
  return absl::InvalidArgumentError(absl::StrCat("PLY: ", why));
}

}  // namespace isthmus::formats
