#include "api/convert/cloud.h"

#include <absl/strings/str_cat.h>

#include <bit>
#include <cstddef>
#include <cstring>
#include <optional>
#include <string>
#include <utility>

#include "api/convert/enum_table.h"

namespace isthmus::convert {
namespace {

static_assert(std::endian::native == std::endian::little);
static_assert(sizeof(MapPoint) == 7 * sizeof(uint32_t));  // Seven fields of four bytes.

struct MapPointField {
  const char* name;
  size_t offset;  // In MapPoint.
  ScalarType type;
};

constexpr MapPointField kMapPointFields[] = {
    {"x", offsetof(MapPoint, x), ScalarType::kFloat32},
    {"y", offsetof(MapPoint, y), ScalarType::kFloat32},
    {"z", offsetof(MapPoint, z), ScalarType::kFloat32},
    {"intensity", offsetof(MapPoint, intensity), ScalarType::kFloat32},
    {"robot", offsetof(MapPoint, robot), ScalarType::kUint32},
    {"label", offsetof(MapPoint, label), ScalarType::kUint32},
    {"last_seen", offsetof(MapPoint, stamp), ScalarType::kUint32},
};

absl::StatusOr<ScalarType> CheckedType(v1::PointField::Type type, const std::string& field) {
  if (type == v1::PointField::TYPE_UNSPECIFIED || !v1::PointField::Type_IsValid(type)) {
    return absl::InvalidArgumentError(
        absl::StrCat("field \"", field, "\" of the cloud has no known type: give INT8 to FLOAT64"));
  }
  return static_cast<ScalarType>(type);  // Same numbers, those of sensor_msgs/PointField.
}

constexpr std::pair<PayloadEncoding, v1::PointCloud::Encoding> kEncodings[] = {
    {PayloadEncoding::kRaw, v1::PointCloud::RAW},
    {PayloadEncoding::kQuantized, v1::PointCloud::QUANTIZED},
    {PayloadEncoding::kDraco, v1::PointCloud::DRACO},
};

// Offsets of a value: in the cloud's points, and in MapPoint.
struct Column {
  uint32_t from;
  size_t to;
};

absl::StatusOr<std::vector<Column>> MapPointColumns(const PointPayload& payload) {
  std::vector<Column> columns;
  for (const MapPointField& wanted : kMapPointFields) {
    for (const PointField& field : payload.fields) {
      if (field.name != wanted.name || field.type != wanted.type) continue;
      if (payload.stride < 4 || field.offset > payload.stride - 4) continue;
      columns.push_back({field.offset, wanted.offset});
      break;
    }
  }
  const bool has_place = columns.size() >= 3 && columns[2].to == offsetof(MapPoint, z);
  const uint64_t size = uint64_t{payload.stride} * payload.width * payload.height;
  if (has_place && payload.data.size() == size) return columns;
  return absl::DataLossError("the server's points are not x y z and what was asked for");
}

}  // namespace

v1::PointCloud LayoutMessage(const PointPayload& payload) {
  v1::PointCloud message;
  message.set_encoding(ToMessage(kEncodings, payload.encoding));
  message.set_width(payload.width);
  message.set_height(payload.height);
  message.set_stride(payload.stride);
  message.set_resolution_m(payload.resolution_m);
  for (const PointField& field : payload.fields) {
    v1::PointField& added = *message.add_fields();
    added.set_name(field.name);
    added.set_offset(field.offset);
    added.set_count(field.count);
    added.set_type(static_cast<v1::PointField::Type>(field.type));  // The same numbers.
  }
  return message;
}

v1::PointCloud ToMessage(PointPayload payload) {
  v1::PointCloud message = LayoutMessage(payload);
  message.set_data(std::move(payload.data));
  return message;
}

absl::StatusOr<PointPayload> FromMessage(v1::PointCloud&& cloud) {
  if (cloud.encoding() == v1::PointCloud::DRACO) {
    return absl::InvalidArgumentError(
        "the server sends DRACO but takes none: give RAW or QUANTIZED");
  }
  return FromServer(std::move(cloud));
}

absl::StatusOr<PointPayload> FromServer(v1::PointCloud&& cloud) {
  if (absl::Status status = CheckBounds(cloud); !status.ok()) return status;
  PointPayload payload;
  const auto encoding = FromMessage(kEncodings, cloud.encoding(), std::optional<PayloadEncoding>());
  if (!encoding) {
    return absl::InvalidArgumentError("the cloud names no known encoding: give RAW or QUANTIZED");
  }
  payload.encoding = *encoding;
  payload.width = cloud.width();
  payload.height = cloud.height() == 0 ? 1 : cloud.height();
  payload.stride = cloud.stride();
  payload.resolution_m = cloud.resolution_m();
  for (const v1::PointField& field : cloud.fields()) {
    const auto type = CheckedType(field.type(), field.name());
    if (!type.ok()) return type.status();
    const uint32_t count = field.count() == 0 ? 1 : field.count();
    payload.fields.push_back({field.name(), field.offset(), *type, count});
  }
  payload.data = std::move(*cloud.mutable_data());
  return payload;
}

PointPayload ToPayload(const std::vector<MapPoint>& points, const MapPointFields& wanted) {
  PointPayload payload;
  payload.width = static_cast<uint32_t>(points.size());
  payload.height = 1;
  std::vector<size_t> offsets;
  for (const MapPointField& field : kMapPointFields) {
    if (field.offset == offsetof(MapPoint, intensity) && !wanted.intensity) continue;
    if (field.offset == offsetof(MapPoint, robot) && !wanted.robot) continue;
    if (field.offset == offsetof(MapPoint, stamp) && !wanted.stamp) continue;
    if (field.offset == offsetof(MapPoint, label) && !wanted.label) continue;
    payload.fields.push_back({field.name, payload.stride, field.type, 1});
    payload.stride += sizeof(uint32_t);
    offsets.push_back(field.offset);
  }
  payload.data.resize(points.size() * payload.stride);
  char* to = payload.data.data();
  for (const MapPoint& point : points) {
    for (const size_t offset : offsets) {
      std::memcpy(to, reinterpret_cast<const char*>(&point) + offset, sizeof(uint32_t));
      to += sizeof(uint32_t);
    }
  }
  return payload;
}

absl::Status AppendPoints(const PointPayload& payload, std::vector<MapPoint>& points) {
  if (payload.width == 0 && payload.data.empty()) return absl::OkStatus();
  const absl::StatusOr<std::vector<Column>> columns = MapPointColumns(payload);
  if (!columns.ok()) return columns.status();
  const char* from = payload.data.data();
  for (size_t i = 0; i < size_t{payload.width} * payload.height; ++i, from += payload.stride) {
    MapPoint& point = points.emplace_back();
    for (const Column& column : *columns) {
      std::memcpy(reinterpret_cast<char*>(&point) + column.to, from + column.from,
                  sizeof(uint32_t));
    }
  }
  return absl::OkStatus();
}

}  // namespace isthmus::convert
