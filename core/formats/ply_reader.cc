#include <absl/strings/ascii.h>
#include <absl/strings/match.h>
#include <absl/strings/numbers.h>
#include <absl/strings/str_cat.h>
#include <absl/strings/str_split.h>

#include <algorithm>
#include <charconv>
#include <optional>
#include <vector>

#include "core/codec/column.h"
#include "core/formats/cloud_file.h"
#include "core/formats/field_names.h"

namespace isthmus::formats {
namespace {

enum class PlyEncoding : uint8_t { kAscii, kLittle, kBig };

struct PlyHeader {
  PlyEncoding encoding = PlyEncoding::kAscii;
  uint64_t points = 0;
  std::vector<PointField> fields;
  uint32_t stride = 0;
  size_t data_start = 0;
};

absl::Status BadPly(const std::string& why) {
  return absl::InvalidArgumentError(absl::StrCat("PLY: ", why));
}

std::optional<ScalarType> PlyType(absl::string_view name) {
  const struct {
    const char *old_name, *name;
    ScalarType type;
  } types[] = {
      {"char", "int8", ScalarType::kInt8},        {"uchar", "uint8", ScalarType::kUint8},
      {"short", "int16", ScalarType::kInt16},     {"ushort", "uint16", ScalarType::kUint16},
      {"int", "int32", ScalarType::kInt32},       {"uint", "uint32", ScalarType::kUint32},
      {"float", "float32", ScalarType::kFloat32}, {"double", "float64", ScalarType::kFloat64}};
  for (const auto& type : types) {
    if (name == type.old_name || name == type.name) return type.type;
  }
  return std::nullopt;
}

absl::Status AddProperty(const std::vector<absl::string_view>& words, PlyHeader& header) {
  if (words.size() != 3) return BadPly("lists as properties of points are not understood");
  const std::optional<ScalarType> type = PlyType(words[1]);
  if (!type) return BadPly(absl::StrCat("unknown type '", words[1], "'"));
  if (header.fields.size() == codec::kMaxFields) return BadPly("too many properties");
  header.fields.push_back({UnderstandColumn(words[2]).name, header.stride, *type, 1});
  header.stride += SizeOf(*type);
  return absl::OkStatus();
}

absl::Status TakeFormat(absl::string_view name, PlyHeader& header) {
  if (name == "ascii") {
    header.encoding = PlyEncoding::kAscii;
  } else if (name == "binary_little_endian") {
    header.encoding = PlyEncoding::kLittle;
  } else if (name == "binary_big_endian") {
    header.encoding = PlyEncoding::kBig;
  } else {
    return BadPly(absl::StrCat("unknown format '", name, "'"));
  }
  return absl::OkStatus();
}

// Reads line by line up to end_header.
class PlyHeaderParser {
 public:
  absl::StatusOr<PlyHeader> Parse(const std::string& bytes) {
    size_t at = 0;
    for (int line = 0;; ++line) {
      const size_t end = bytes.find('\n', at);
      if (end == std::string::npos || line > 10'000) return BadPly("the header has no end_header");
      absl::string_view text(bytes.data() + at, end - at);
      at = end + 1;
      if (line == 0) {
        if (!absl::StartsWith(text, "ply")) return BadPly("it does not begin with 'ply'");
        continue;
      }
      const std::vector<absl::string_view> words =
          absl::StrSplit(text, absl::ByAnyChar(" \t\r"), absl::SkipEmpty());
      if (words.empty()) continue;
      if (words[0] == "end_header") break;
      if (absl::Status status = TakeLine(words); !status.ok()) return status;
    }
    if (!has_vertices_) return BadPly("there is no element 'vertex'");
    if (header_.fields.empty()) return BadPly("points have no properties");
    header_.data_start = at;
    return header_;
  }

 private:
  absl::Status TakeLine(const std::vector<absl::string_view>& words) {
    if (words[0] == "format" && words.size() >= 2) return TakeFormat(words[1], header_);
    if (words[0] == "element" && words.size() == 3) {
      in_vertices_ = words[1] == "vertex";
      if (!in_vertices_) {
        return has_vertices_ ? absl::OkStatus()
                             : BadPly(absl::StrCat("element '", words[1], "' before the points"));
      }
      has_vertices_ = true;
      if (!absl::SimpleAtoi(words[2], &header_.points)) return BadPly("bad number of points");
    }
    if (words[0] == "property" && in_vertices_) return AddProperty(words, header_);
    return absl::OkStatus();
  }

  PlyHeader header_;
  bool in_vertices_ = false, has_vertices_ = false;
};

absl::StatusOr<std::string> AsciiRecords(const std::string& bytes, const PlyHeader& header) {
  // A value takes a digit and what parts it from the next. Checked before memory is taken.
  if (header.points > (bytes.size() - header.data_start + 1) / 2 / header.fields.size()) {
    return BadPly("fewer rows than the header announces: is the file truncated?");
  }
  std::string records(header.points * header.stride, '\0');
  const char* at = bytes.data() + header.data_start;
  const char* const end = bytes.data() + bytes.size();
  char* out = records.data();
  for (uint64_t i = 0; i < header.points; ++i) {
    for (const PointField& field : header.fields) {
      while (at < end && absl::ascii_isspace(*at)) ++at;
      const bool read = codec::VisitScalar(field.type, [&](auto scalar) {
        // "1.0" as an integer, as some write it.
        double value = 0;
        const auto parsed = std::from_chars(at, end, value);
        if (parsed.ec != std::errc()) return false;
        using T = decltype(scalar);
        if constexpr (std::is_integral_v<T>) {
          if (!(value >= static_cast<double>(std::numeric_limits<T>::min()) &&
                value <= static_cast<double>(std::numeric_limits<T>::max()))) {
            return false;
          }
        }
        codec::StoreAs(static_cast<T>(value), out);
        at = parsed.ptr;
        return true;
      });
      if (!read) {
        return BadPly(absl::StrCat("point ", i + 1, " has no number for '", field.name, "'"));
      }
      out += SizeOf(field.type);
    }
  }
  return records;
}

void SwapBytes(const PlyHeader& header, std::string& records) {
  for (char* record = records.data(); record < records.data() + records.size();
       record += header.stride) {
    for (const PointField& field : header.fields) {
      std::reverse(record + field.offset, record + field.offset + SizeOf(field.type));
    }
  }
}

}  // namespace

absl::StatusOr<PointPayload> ParsePly(const std::string& bytes) {
  absl::StatusOr<PlyHeader> header = PlyHeaderParser().Parse(bytes);
  if (!header.ok()) return header.status();
  if (header->points > std::numeric_limits<uint32_t>::max()) return BadPly("too many points");
  absl::StatusOr<std::string> records;
  if (header->encoding == PlyEncoding::kAscii) {
    records = AsciiRecords(bytes, *header);
    if (!records.ok()) return records.status();
  } else {
    if (header->points > (bytes.size() - header->data_start) / header->stride) {
      return BadPly(absl::StrCat("the header announces ", header->points,
                                 " points, but there is less: is the file truncated?"));
    }
    records = bytes.substr(header->data_start, header->points * header->stride);
    if (header->encoding == PlyEncoding::kBig) SwapBytes(*header, *records);
  }
  PointPayload payload;
  payload.width = static_cast<uint32_t>(header->points);
  payload.stride = header->stride;
  payload.fields = std::move(header->fields);
  payload.data = *std::move(records);
  return payload;
}

}  // namespace isthmus::formats
