#include "api/convert/cloud.h"

#include <absl/strings/str_cat.h>

#include <bit>
#include <cstddef>
#include <cstring>
#include <string>
#include <utility>

namespace isthmus::convert {
namespace {

// A point of the map is sent as it begins in memory.
static_assert(std::endian::native == std::endian::little);

struct MapPointField {
  const char* name;
  uint32_t offset;
  v1::PointField::Type type;
};

constexpr MapPointField kMapPointFields[] = {
    {"x", offsetof(MapPoint, x), v1::PointField::FLOAT32},
    {"y", offsetof(MapPoint, y), v1::PointField::FLOAT32},
    {"z", offsetof(MapPoint, z), v1::PointField::FLOAT32},
    {"intensity", offsetof(MapPoint, intensity), v1::PointField::FLOAT32},
    {"robot", offsetof(MapPoint, robot), v1::PointField::UINT32},
};

absl::StatusOr<ScalarType> CheckedType(v1::PointField::Type type, const std::string& field) {
  if (type == v1::PointField::TYPE_UNSPECIFIED || !v1::PointField::Type_IsValid(type)) {
    return absl::InvalidArgumentError(
        absl::StrCat("field \"", field, "\" of the cloud has no known type: give INT8 to FLOAT64"));
  }
  return static_cast<ScalarType>(type);  // Same numbers, those of sensor_msgs/PointField.
}

// Names are quoted, kept and listed.
constexpr size_t kMaxFieldName = 64;
constexpr int kMaxFields = 256;

absl::Status CheckFields(const v1::PointCloud& cloud) {
  if (cloud.fields_size() > kMaxFields) {
    return absl::InvalidArgumentError(
        absl::StrCat("the cloud has ", cloud.fields_size(), " fields: give at most ", kMaxFields));
  }
  for (const v1::PointField& field : cloud.fields()) {
    if (field.name().size() <= kMaxFieldName) continue;
    return absl::InvalidArgumentError(absl::StrCat("a field's name has ", field.name().size(),
                                                   " characters: give at most ", kMaxFieldName));
  }
  return absl::OkStatus();
}

absl::StatusOr<PayloadEncoding> CheckedEncoding(v1::PointCloud::Encoding encoding) {
  switch (encoding) {
    case v1::PointCloud::RAW:
      return PayloadEncoding::kRaw;
    case v1::PointCloud::QUANTIZED:
      return PayloadEncoding::kQuantized;
    default:
      return absl::InvalidArgumentError("the cloud names no known encoding: give RAW or QUANTIZED");
  }
}

bool HasMapPoints(const v1::PointCloud& cloud) {
  int known = 0;
  for (const MapPointField& field : kMapPointFields) {
    if (known == cloud.fields_size()) return false;
    const v1::PointField& given = cloud.fields(known++);
    if (given.name() != field.name || given.offset() != field.offset) return false;
  }
  return cloud.stride() >= kMapRecordBytes &&
         cloud.data().size() == uint64_t{cloud.stride()} * cloud.width();
}

}  // namespace

v1::PointCloud LayoutMessage(const PointPayload& payload) {
  v1::PointCloud message;
  message.set_encoding(payload.encoding == PayloadEncoding::kRaw ? v1::PointCloud::RAW
                                                                 : v1::PointCloud::QUANTIZED);
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
  if (absl::Status status = CheckFields(cloud); !status.ok()) return status;
  PointPayload payload;
  const auto encoding = CheckedEncoding(cloud.encoding());
  if (!encoding.ok()) return encoding.status();
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

v1::PointCloud ToMessage(const std::vector<MapPoint>& points) {
  v1::PointCloud cloud;
  cloud.set_encoding(v1::PointCloud::RAW);
  cloud.set_width(static_cast<uint32_t>(points.size()));
  cloud.set_height(1);
  cloud.set_stride(kMapRecordBytes);
  for (const MapPointField& field : kMapPointFields) {
    v1::PointField& added = *cloud.add_fields();
    added.set_name(field.name);
    added.set_offset(field.offset);
    added.set_type(field.type);
    added.set_count(1);
  }
  cloud.mutable_data()->resize(points.size() * kMapRecordBytes);
  CopyMapRecords(points, cloud.mutable_data()->data());
  return cloud;
}

absl::Status AppendPoints(const v1::PointCloud& cloud, std::vector<MapPoint>& points) {
  if (cloud.width() == 0 && cloud.data().empty()) return absl::OkStatus();
  if (!HasMapPoints(cloud)) {
    return absl::DataLossError("the server's points are not x y z intensity robot");
  }
  for (uint32_t i = 0; i < cloud.width(); ++i) {
    MapPoint point;
    std::memcpy(static_cast<void*>(&point), cloud.data().data() + size_t{cloud.stride()} * i,
                kMapRecordBytes);
    points.push_back(point);
  }
  return absl::OkStatus();
}

}  // namespace isthmus::convert
