#include "core/formats/map_writer.h"

#include <absl/strings/ascii.h>
#include <absl/strings/str_cat.h>

#include <array>
#include <cstring>
#include <limits>

#include "core/codec/column.h"
#include "core/formats/lzf.h"
#include "core/formats/pcd_ascii.h"
#include "core/formats/pcd_header.h"

namespace isthmus::formats {
namespace {

constexpr std::array<const char*, 4> kFloatFields = {"x", "y", "z", "intensity"};
constexpr std::array<const char*, 2> kNumberFields = {"robot", "label"};

std::vector<std::string> RobotComments(const std::vector<RobotId>& robots) {
  std::vector<std::string> comments;
  for (size_t i = 0; i < robots.size(); ++i) {
    std::string name = robots[i].value();
    for (char& c : name) c = absl::ascii_iscntrl(static_cast<unsigned char>(c)) ? ' ' : c;
    comments.push_back(absl::StrCat("robot ", i, " ", name));
  }
  return comments;
}

std::string Records(const std::vector<MapPoint>& points) {
  std::string bytes(points.size() * kMapRecordBytes, '\0');
  CopyMapRecords(points, bytes.data());
  return bytes;
}

std::string Rows(const std::vector<MapPoint>& points) {
  std::string text;
  for (const MapPoint& point : points) {
    for (const float value : {point.x, point.y, point.z, point.intensity}) {
      AppendValue(reinterpret_cast<const char*>(&value), ScalarType::kFloat32, text);
      text.push_back(' ');
    }
    AppendValue(reinterpret_cast<const char*>(&point.robot), ScalarType::kUint32, text);
    text.push_back(' ');
    AppendValue(reinterpret_cast<const char*>(&point.label), ScalarType::kUint32, text);
    text.push_back('\n');
  }
  return text;
}

}  // namespace

std::string PcdMapHeader(uint64_t points, PcdEncoding encoding,
                         const std::vector<RobotId>& robots) {
  PcdHeader header;
  for (const char* name : kFloatFields) {
    header.fields.push_back(ToPcdField(name, ScalarType::kFloat32, 1));
  }
  for (const char* name : kNumberFields) {
    header.fields.push_back(ToPcdField(name, ScalarType::kUint32, 1));
  }
  header.width = static_cast<uint32_t>(points);
  header.encoding = encoding;
  return FormatPcdHeader(header, RobotComments(robots));
}

std::string PcdMapChunk(const std::vector<MapPoint>& points, PcdEncoding encoding) {
  return encoding == PcdEncoding::kAscii ? Rows(points) : Records(points);
}

absl::StatusOr<std::string> PcdMapCompressed(const std::vector<MapPoint>& points) {
  // Every field has four bytes.
  std::string columns(points.size() * kMapRecordBytes, '\0');
  const auto* records = reinterpret_cast<const char*>(points.data());
  char* out = columns.data();
  for (size_t offset = 0; offset < kMapRecordBytes; offset += 4) {
    for (size_t i = 0; i < points.size(); ++i, out += 4) {
      std::memcpy(out, records + i * sizeof(MapPoint) + offset, 4);
    }
  }
  return LzfBlock(columns);
}

std::string PlyMapHeader(uint64_t points, const std::vector<RobotId>& robots) {
  std::string text = "ply\nformat binary_little_endian 1.0\n";
  for (const std::string& comment : RobotComments(robots)) {
    absl::StrAppend(&text, "comment ", comment, "\n");
  }
  absl::StrAppend(&text, "element vertex ", points, "\n");
  for (const char* name : kFloatFields) absl::StrAppend(&text, "property float ", name, "\n");
  for (const char* name : kNumberFields) absl::StrAppend(&text, "property uint ", name, "\n");
  return text + "end_header\n";
}

std::string PlyMapChunk(const std::vector<MapPoint>& points) { return Records(points); }

}  // namespace isthmus::formats
