#include "core/codec/payload_layout.h"

#include <absl/strings/match.h>
#include <absl/strings/str_cat.h>

#include "core/codec/column.h"

namespace isthmus::codec {
namespace {

absl::Status CheckFields(const PointPayload& payload) {
  if (payload.fields.empty() || payload.fields.size() > kMaxFields) {
    return absl::InvalidArgumentError(absl::StrCat(
        "a cloud has 1 to ", kMaxFields, " fields; this one has ", payload.fields.size()));
  }
  if (payload.stride == 0 || payload.stride > kMaxStride) {
    return absl::InvalidArgumentError(absl::StrCat("the stride of a record must be 1 to ",
                                                   kMaxStride, " bytes; it is ", payload.stride));
  }
  for (const PointField& field : payload.fields) {
    const uint64_t size = SizeOf(field.type);
    if (size == 0 || field.count == 0) {
      return absl::InvalidArgumentError(
          absl::StrCat("field '", field.name, "' has an unknown type or a count of zero"));
    }
    if (field.offset + size * field.count > payload.stride) {
      return absl::InvalidArgumentError(absl::StrCat(
          "field '", field.name, "' ends at byte ", field.offset + size * field.count,
          " of a record of ", payload.stride, "; check its offset, count and the stride"));
    }
  }
  return absl::OkStatus();
}

absl::Status CheckDataSize(const PointPayload& raw) {
  // More points than bytes cannot be right; fewer cannot overflow the product, strides being small.
  const uint64_t points = PointCount(raw);
  if (points <= raw.data.size() && points * raw.stride == raw.data.size()) {
    return absl::OkStatus();
  }
  return absl::InvalidArgumentError(absl::StrCat(
      raw.width, " x ", raw.height, " points of ", raw.stride, " bytes do not make the ",
      raw.data.size(), " bytes of data; check width, height and stride"));
}

}  // namespace

absl::Status CheckRawLayout(const PointPayload& payload) {
  if (payload.encoding != PayloadEncoding::kRaw) {
    return absl::InvalidArgumentError("the payload is compressed; decompress it first");
  }
  if (absl::Status status = CheckFields(payload); !status.ok()) return status;
  return CheckDataSize(payload);
}

absl::Status CheckLayout(const PointPayload& payload) {
  if (absl::Status status = CheckFields(payload); !status.ok()) return status;
  const uint64_t points = PointCount(payload);
  if (points == 0) return absl::InvalidArgumentError("the scan is empty: it has no points");
  if (points > kMaxScanPoints || points * payload.stride > kMaxDecodedBytes) {
    return absl::InvalidArgumentError(
        absl::StrCat("a scan is limited to ", kMaxScanPoints, " points and ", kMaxDecodedBytes,
                     " bytes; this one claims ", points, " points of ", payload.stride, " bytes"));
  }
  if (payload.encoding == PayloadEncoding::kRaw) return CheckDataSize(payload);
  return absl::OkStatus();
}

const PointField* FindField(const PointPayload& payload, std::initializer_list<const char*> names) {
  for (const char* name : names) {
    for (const PointField& field : payload.fields) {
      if (absl::EqualsIgnoreCase(field.name, name)) return &field;
    }
  }
  return nullptr;
}

const PointField* FindRingField(const PointPayload& payload) {
  return FindField(payload, {"ring", "ring_id", "channel", "line", "row", "laser_id", "laser",
                             "beam", "beam_id"});
}

const PointField* FindPlainTimeField(const PointPayload& payload) {
  return FindField(payload, {"time", "t", "timestamp", "time_stamp", "offset_time", "timeoffset",
                             "time_offset", "relative_time", "point_time", "ts"});
}

std::vector<double> ReadColumn(const PointPayload& raw, const PointField& field) {
  std::vector<double> values(PointCount(raw));
  ForEachValue(raw, field, [&](uint64_t i, auto value) { values[i] = static_cast<double>(value); });
  return values;
}

const char* ToString(ScalarType type) {
  switch (type) {
    case ScalarType::kInt8:
      return "int8";
    case ScalarType::kUint8:
      return "uint8";
    case ScalarType::kInt16:
      return "int16";
    case ScalarType::kUint16:
      return "uint16";
    case ScalarType::kInt32:
      return "int32";
    case ScalarType::kUint32:
      return "uint32";
    case ScalarType::kFloat32:
      return "float32";
    case ScalarType::kFloat64:
      return "float64";
  }
  return "unknown";
}

}  // namespace isthmus::codec
