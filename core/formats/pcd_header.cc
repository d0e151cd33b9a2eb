#include "core/formats/pcd_header.h"

#include <absl/strings/ascii.h>
#include <absl/strings/numbers.h>
#include <absl/strings/str_cat.h>
#include <absl/strings/str_split.h>

#include <array>
#include <cmath>
#include <map>
#include <utility>

#include "core/codec/payload_layout.h"
#include "core/formats/field_names.h"
#include "core/formats/pcd_ascii.h"

namespace isthmus::formats {
namespace {

using Words = std::vector<std::string>;
// Words of a line by its key.
using Lines = std::map<std::string, Words>;

absl::Status Bad(const std::string& why) {
  return absl::InvalidArgumentError(absl::StrCat("PCD header: ", why));
}

bool IsKnownKey(const std::string& key) {
  for (const char* known :
       {"FIELDS", "SIZE", "TYPE", "COUNT", "WIDTH", "HEIGHT", "VIEWPOINT", "POINTS", "DATA"}) {
    if (key == known) return true;
  }
  return false;
}

// Splits up to and with the DATA line; `end` becomes the byte behind it.
absl::StatusOr<Lines> SplitLines(const std::string& bytes, size_t* end) {
  Lines lines;
  for (size_t start = 0; lines.count("DATA") == 0;) {
    const size_t newline = bytes.find('\n', start);
    if (newline == std::string::npos) return Bad("there is no DATA line; is this a PCD file?");
    const std::string line(
        absl::StripAsciiWhitespace(absl::string_view(&bytes[start], newline - start)));
    start = newline + 1;
    *end = start;
    if (line.empty() || line[0] == '#') continue;
    Words words = absl::StrSplit(line, absl::ByAnyChar(" \t"), absl::SkipEmpty());
    std::string key = words.front();
    if (key == "COLUMNS") key = "FIELDS";  // Before version 0.7.
    if (!IsKnownKey(key)) continue;
    words.erase(words.begin());
    if (!lines.emplace(key, std::move(words)).second) return Bad(absl::StrCat(key, " twice"));
  }
  return lines;
}

// Empty where there is no such line.
absl::StatusOr<std::optional<uint32_t>> ParseCount(const Lines& lines, const std::string& key) {
  const auto line = lines.find(key);
  if (line == lines.end()) return std::nullopt;
  uint32_t value = 0;
  if (line->second.size() != 1 || !absl::SimpleAtoi(line->second[0], &value)) {
    return Bad(absl::StrCat(key, " must be one whole number from 0 to 2^32 - 1"));
  }
  return value;
}

// Into the header.
absl::Status ParseSize(const Lines& lines, PcdHeader& header) {
  const auto width = ParseCount(lines, "WIDTH");
  if (!width.ok()) return width.status();
  const auto height = ParseCount(lines, "HEIGHT");
  if (!height.ok()) return height.status();
  const auto points = ParseCount(lines, "POINTS");
  if (!points.ok()) return points.status();
  if (!*width && !*points) return Bad("neither WIDTH nor POINTS tells how many points there are");
  header.width = width->value_or(0);
  header.height = height->value_or(1);
  if (header.Points() == 0) {
    header.width = points->value_or(header.width);
    header.height = 1;
  }
  if (*points && **points != header.Points()) {
    return Bad(absl::StrCat("POINTS is ", **points, " but WIDTH x HEIGHT is ", header.Points()));
  }
  return absl::OkStatus();
}

// One word of each of SIZE, TYPE and COUNT.
absl::StatusOr<PcdField> ParseField(const std::string& name, const std::string& size,
                                    const std::string& type, const std::string& count) {
  PcdField field;
  field.name = name;
  field.kind = type.size() == 1 ? type[0] : '?';
  if (!absl::SimpleAtoi(size, &field.size) || !absl::SimpleAtoi(count, &field.count) ||
      uint64_t{field.size} * field.count > codec::kMaxStride || field.count > codec::kMaxStride) {
    return Bad(absl::StrCat("field '", name, "' has a bad SIZE or COUNT"));
  }
  if (IsAxis(name) && !ToScalarType(field)) {
    return Bad(absl::StrCat("field '", name, "' has ", count, " values of TYPE ", type,
                            " and SIZE ", size, ", which cannot be read"));
  }
  return field;
}

absl::StatusOr<std::vector<PcdField>> ParseFields(const Lines& lines) {
  if (lines.count("FIELDS") == 0) return Bad("there is no FIELDS line");
  const Words& names = lines.at("FIELDS");
  const auto words_of = [&](const char* key, const char* unless_there) {
    return lines.count(key) ? lines.at(key) : Words(names.size(), unless_there);
  };
  const Words sizes = words_of("SIZE", "4"), types = words_of("TYPE", "F"),
              counts = words_of("COUNT", "1");
  if (names.empty() || names.size() > codec::kMaxFields || sizes.size() != names.size() ||
      types.size() != names.size() || counts.size() != names.size()) {
    return Bad(absl::StrCat("FIELDS, SIZE, TYPE and COUNT must agree and name 1 to ",
                            codec::kMaxFields, " fields"));
  }
  std::vector<PcdField> fields;
  uint64_t stride = 0;
  for (size_t i = 0; i < names.size(); ++i) {
    absl::StatusOr<PcdField> field = ParseField(names[i], sizes[i], types[i], counts[i]);
    if (!field.ok()) return field.status();
    stride += field->Bytes();
    fields.push_back(*std::move(field));
  }
  if (stride == 0 || stride > codec::kMaxStride) {
    return Bad(absl::StrCat("a point must have 1 to ", codec::kMaxStride, " bytes"));
  }
  return fields;
}

Pose ParseViewpoint(const Lines& lines) {
  const auto line = lines.find("VIEWPOINT");
  if (line == lines.end()) return Pose();
  std::array<double, 7> v{};
  bool good = line->second.size() == v.size();
  for (size_t i = 0; good && i < v.size(); ++i) {
    good = absl::SimpleAtod(line->second[i], &v[i]) && std::isfinite(v[i]);
  }
  const Eigen::Quaterniond rotation(v[3], v[4], v[5], v[6]);
  if (!good || rotation.norm() < 1e-3) return Pose();
  return Pose(rotation, Eigen::Vector3d(v[0], v[1], v[2]));
}

absl::StatusOr<PcdEncoding> ParseEncoding(const Words& words) {
  const std::string word = words.size() == 1 ? words[0] : "";
  if (word == "ascii") return PcdEncoding::kAscii;
  if (word == "binary") return PcdEncoding::kBinary;
  if (word == "binary_compressed") return PcdEncoding::kBinaryCompressed;
  return Bad("DATA must be ascii, binary or binary_compressed");
}

const char* Name(PcdEncoding encoding) {
  switch (encoding) {
    case PcdEncoding::kAscii:
      return "ascii";
    case PcdEncoding::kBinary:
      return "binary";
    case PcdEncoding::kBinaryCompressed:
      return "binary_compressed";
  }
  return "";
}

}  // namespace

uint32_t PcdHeader::Stride() const {
  uint32_t stride = 0;
  for (const PcdField& field : fields) stride += field.Bytes();
  return stride;
}

absl::StatusOr<PcdHeader> ParsePcdHeader(const std::string& bytes) {
  PcdHeader header;
  absl::StatusOr<Lines> lines = SplitLines(bytes, &header.data_start);
  if (!lines.ok()) return lines.status();
  absl::StatusOr<std::vector<PcdField>> fields = ParseFields(*lines);
  if (!fields.ok()) return fields.status();
  if (absl::Status status = ParseSize(*lines, header); !status.ok()) return status;
  absl::StatusOr<PcdEncoding> encoding = ParseEncoding(lines->at("DATA"));
  if (!encoding.ok()) return encoding.status();
  header.fields = *std::move(fields);
  header.viewpoint = ParseViewpoint(*lines);
  header.encoding = *encoding;
  return header;
}

std::string FormatPcdHeader(const PcdHeader& header, const std::vector<std::string>& comments) {
  std::string text = "# .PCD v0.7 - Point Cloud Data file format\n";
  for (std::string comment : comments) {
    for (char& c : comment) c = absl::ascii_iscntrl(static_cast<unsigned char>(c)) ? ' ' : c;
    absl::StrAppend(&text, "# ", comment, "\n");
  }
  std::string names, sizes, types, counts;
  for (const PcdField& field : header.fields) {
    absl::StrAppend(&names, " ", field.name);
    absl::StrAppend(&sizes, " ", field.size);
    absl::StrAppend(&types, " ", std::string(1, field.kind));
    absl::StrAppend(&counts, " ", field.count);
  }
  const Eigen::Vector3d& t = header.viewpoint.translation();
  const Eigen::Quaterniond& q = header.viewpoint.rotation();
  absl::StrAppend(&text, "VERSION 0.7\nFIELDS", names, "\nSIZE", sizes, "\nTYPE", types);
  absl::StrAppend(&text, "\nCOUNT", counts, "\nWIDTH ", header.width, "\nHEIGHT ", header.height);
  absl::StrAppend(&text, "\nVIEWPOINT");
  for (const double value : {t.x(), t.y(), t.z(), q.w(), q.x(), q.y(), q.z()}) {
    text.push_back(' ');
    AppendValue(reinterpret_cast<const char*>(&value), ScalarType::kFloat64, text);
  }
  absl::StrAppend(&text, "\nPOINTS ", header.Points(), "\nDATA ", Name(header.encoding), "\n");
  return text;
}

PcdField ToPcdField(const std::string& name, ScalarType type, uint32_t count) {
  const bool floating = type == ScalarType::kFloat32 || type == ScalarType::kFloat64;
  const bool is_signed =
      type == ScalarType::kInt8 || type == ScalarType::kInt16 || type == ScalarType::kInt32;
  return {name, floating ? 'F' : (is_signed ? 'I' : 'U'), SizeOf(type), count};
}

std::optional<ScalarType> ToScalarType(const PcdField& field) {
  if (field.IsPadding() || field.count == 0) return std::nullopt;
  static const std::map<std::pair<char, uint32_t>, ScalarType> kTypes = {
      {{'I', 1}, ScalarType::kInt8},    {{'U', 1}, ScalarType::kUint8},
      {{'I', 2}, ScalarType::kInt16},   {{'U', 2}, ScalarType::kUint16},
      {{'I', 4}, ScalarType::kInt32},   {{'U', 4}, ScalarType::kUint32},
      {{'F', 4}, ScalarType::kFloat32}, {{'F', 8}, ScalarType::kFloat64},
      {{'I', 8}, ScalarType::kFloat64}, {{'U', 8}, ScalarType::kFloat64}};
  const auto type = kTypes.find({field.kind, field.size});
  return type == kTypes.end() ? std::nullopt : std::optional(type->second);
}

}  // namespace isthmus::formats
