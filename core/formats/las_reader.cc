#include <absl/strings/match.h>
#include <absl/strings/str_cat.h>
#include <absl/strings/string_view.h>

#include <limits>

#include "core/codec/column.h"
#include "core/formats/cloud_file.h"
#include "core/formats/las_units.h"

namespace isthmus::formats {
namespace {

// Offsets of the public header block, LAS 1.4 R15, table 3.
constexpr size_t kVersionMinor = 25, kHeaderSize = 94, kDataStart = 96, kRecords = 100,
                 kFormat = 104, kExtendedStart = 235, kExtendedRecords = 243, kRecordLength = 105,
                 kLegacyPoints = 107, kScale = 131, kOffset = 155, kPoints = 247,
                 kLeastHeader = 227, kLeastHeader14 = 375;

struct LasHeader {
  uint32_t data_start = 0;
  uint8_t format = 0;
  uint16_t record_length = 0;
  uint64_t points = 0;
  double scale[3] = {}, offset[3] = {};  // Both to metres.
};

// The records that tell the coordinate reference system; empty: there is none.
struct LasSystem {
  absl::string_view wkt, geo_keys, geo_doubles;
};

// Takes what it knows of a series of variable length records (section 2.5), or of extended ones
// (2.7), whose length has 8 bytes in place of 2.
void TakeRecords(absl::string_view left, uint32_t count, bool are_extended, LasSystem& system) {
  const size_t head = are_extended ? 60 : 54;
  for (uint32_t i = 0; i < count && left.size() >= head; ++i) {
    const auto id = codec::LoadAs<uint16_t>(left.data() + 18);
    const uint64_t length = are_extended ? codec::LoadAs<uint64_t>(left.data() + 20)
                                         : codec::LoadAs<uint16_t>(left.data() + 20);
    const bool is_known = absl::StartsWith(left.substr(2), "LASF_Projection");
    left.remove_prefix(head);
    const absl::string_view data = left.substr(0, length);
    left.remove_prefix(data.size());
    if (is_known && id == 2112) system.wkt = data;
    if (is_known && id == 34735) system.geo_keys = data;
    if (is_known && id == 34736) system.geo_doubles = data;
  }
}

absl::StatusOr<LasUnits> UnitsOfFile(absl::string_view bytes, uint8_t minor) {
  const char* at = bytes.data();
  LasSystem system;
  const size_t header_size = codec::LoadAs<uint16_t>(at + kHeaderSize);
  if (header_size < bytes.size()) {
    TakeRecords(bytes.substr(header_size), codec::LoadAs<uint32_t>(at + kRecords), false, system);
  }
  if (minor == 4) {
    const auto start = codec::LoadAs<uint64_t>(at + kExtendedStart);
    const auto count = codec::LoadAs<uint32_t>(at + kExtendedRecords);
    if (start < bytes.size()) TakeRecords(bytes.substr(start), count, true, system);
  }
  return system.wkt.empty() ? UnitsOfGeoKeys(system.geo_keys, system.geo_doubles)
                            : UnitsOfWkt(system.wkt);
}

// The offset of GPS time in a record of that format; 0: it has none (tables 7 to 17).
uint32_t GpsTimeAt(uint8_t format) {
  if (format >= 6) return 22;
  return format == 0 || format == 2 ? 0 : 20;
}

// Bytes of a record without what a program adds to it.
uint32_t LeastRecord(uint8_t format) {
  constexpr uint32_t kLengths[] = {20, 28, 26, 34, 57, 63, 30, 36, 38, 59, 67};
  return kLengths[format];
}

absl::Status BadLas(const std::string& why) {
  return absl::InvalidArgumentError(absl::StrCat("LAS: ", why));
}

absl::StatusOr<LasHeader> ParseLasHeader(const std::string& bytes) {
  if (bytes.size() < kLeastHeader || !bytes.starts_with("LASF")) {
    return BadLas("it does not begin with a LAS header");
  }
  const char* at = bytes.data();
  const auto minor = codec::LoadAs<uint8_t>(at + kVersionMinor);
  const auto header_size = codec::LoadAs<uint16_t>(at + kHeaderSize);
  if (minor > 4) return BadLas(absl::StrCat("version 1.", minor, " is not known"));
  if (minor == 4 && (header_size < kLeastHeader14 || bytes.size() < kLeastHeader14)) {
    return BadLas("the header is cut off");
  }
  LasHeader header;
  header.data_start = codec::LoadAs<uint32_t>(at + kDataStart);
  header.format = codec::LoadAs<uint8_t>(at + kFormat);
  // LASzip marks its files here.
  if ((header.format & 0xC0) != 0) {
    return BadLas(
        "the file is compressed (LAZ), which this program cannot read: convert it to .las first, "
        "with laszip, PDAL or CloudCompare");
  }
  if (header.format > 10) return BadLas(absl::StrCat("unknown point format ", header.format));
  header.record_length = codec::LoadAs<uint16_t>(at + kRecordLength);
  if (header.record_length < LeastRecord(header.format)) {
    return BadLas("records are shorter than their format says");
  }
  header.points = codec::LoadAs<uint32_t>(at + kLegacyPoints);
  // Some fill the old number in alone.
  const uint64_t points = minor == 4 ? codec::LoadAs<uint64_t>(at + kPoints) : 0;
  if (points > 0) header.points = points;
  const absl::StatusOr<LasUnits> units = UnitsOfFile(bytes, minor);
  if (!units.ok()) return units.status();
  for (int axis = 0; axis < 3; ++axis) {
    const double metres = axis == 2 ? units->vertical_m : units->horizontal_m;
    header.scale[axis] = codec::LoadAs<double>(at + kScale + 8 * axis) * metres;
    header.offset[axis] = codec::LoadAs<double>(at + kOffset + 8 * axis) * metres;
  }
  return header;
}

}  // namespace

absl::StatusOr<PointPayload> ParseLas(const std::string& bytes) {
  const absl::StatusOr<LasHeader> header = ParseLasHeader(bytes);
  if (!header.ok()) return header.status();
  if (header->data_start > bytes.size() ||
      header->points > (bytes.size() - header->data_start) / header->record_length) {
    return BadLas(absl::StrCat("the header announces ", header->points,
                               " points, but there is less: is the file truncated?"));
  }
  if (header->points > std::numeric_limits<uint32_t>::max()) return BadLas("too many points");
  const uint32_t time_at = GpsTimeAt(header->format);
  PointPayload payload;
  payload.width = static_cast<uint32_t>(header->points);
  payload.fields = {{"x", 0, ScalarType::kFloat64, 1},
                    {"y", 8, ScalarType::kFloat64, 1},
                    {"z", 16, ScalarType::kFloat64, 1},
                    {"intensity", 24, ScalarType::kUint16, 1}};
  payload.stride = 26;
  if (time_at != 0) {
    payload.fields.push_back({"time", payload.stride, ScalarType::kFloat64, 1});
    payload.stride += 8;
  }
  payload.data.resize(header->points * payload.stride);
  const char* in = bytes.data() + header->data_start;
  char* out = payload.data.data();
  for (uint64_t i = 0; i < header->points; ++i, in += header->record_length) {
    for (int axis = 0; axis < 3; ++axis) {
      codec::StoreAs(
          codec::LoadAs<int32_t>(in + 4 * axis) * header->scale[axis] + header->offset[axis],
          out + 8 * axis);
    }
    codec::StoreAs(codec::LoadAs<uint16_t>(in + 12), out + 24);
    if (time_at != 0) codec::StoreAs(codec::LoadAs<double>(in + time_at), out + 26);
    out += payload.stride;
  }
  return payload;
}

}  // namespace isthmus::formats
