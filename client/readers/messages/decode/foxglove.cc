#include <array>
#include <utility>

#include "client/readers/messages/decode/cloud_message.h"
#include "client/readers/messages/decode/protobuf_reader.h"
#include "core/codec/payload_layout.h"

namespace isthmus::readers {
namespace {

// google.protobuf.Timestamp.
int64_t ReadProtobufTime(absl::string_view bytes) {
  uint64_t seconds = 0, nanos = 0;
  ProtobufReader reader(bytes);
  for (ProtobufField field; reader.Next(field);) {
    if (field.number == 1) seconds = field.value;
    if (field.number == 2) nanos = field.value;
  }
  // Unsigned: what is damaged overflows without harm.
  return static_cast<int64_t>(seconds * 1'000'000'000 + nanos);
}

// foxglove.PackedElementField; of an unknown type: false.
bool ReadElementField(absl::string_view bytes, PointField& element) {
  // By foxglove.PackedElementField.NumericType.
  constexpr std::array<ScalarType, 9> kTypes = {
      ScalarType{0},       ScalarType::kUint8,   ScalarType::kInt8,
      ScalarType::kUint16, ScalarType::kInt16,   ScalarType::kUint32,
      ScalarType::kInt32,  ScalarType::kFloat32, ScalarType::kFloat64};
  element.type = ScalarType{0};
  ProtobufReader reader(bytes);
  for (ProtobufField field; reader.Next(field);) {
    if (field.number == 1) element.name = std::string(field.bytes);
    if (field.number == 2) element.offset = static_cast<uint32_t>(field.value);
    if (field.number == 3 && field.value < kTypes.size()) element.type = kTypes[field.value];
  }
  return reader.ok() && SizeOf(element.type) > 0;
}

}  // namespace

absl::StatusOr<CloudMessage> DecodeFoxglove(absl::string_view bytes) {
  CloudMessage cloud;
  PointPayload& payload = cloud.payload;
  absl::string_view data;
  ProtobufReader reader(bytes);
  for (ProtobufField field; reader.Next(field);) {
    if (field.number == 1) cloud.header.stamp_ns = ReadProtobufTime(field.bytes);
    if (field.number == 2) cloud.header.frame = std::string(field.bytes);
    if (field.number == 4) payload.stride = static_cast<uint32_t>(field.value);
    if (field.number == 5) {
      PointField element;
      if (ReadElementField(field.bytes, element)) payload.fields.push_back(std::move(element));
      if (payload.fields.size() > codec::kMaxFields) break;
    }
    if (field.number == 6) data = field.bytes;
  }
  if (!reader.ok()) return TooShort("foxglove.PointCloud");
  if (payload.stride > 0) payload.width = static_cast<uint32_t>(data.size() / payload.stride);
  payload.data = std::string(data);
  if (absl::Status status = codec::CheckLayout(payload); !status.ok()) return status;
  return cloud;
}

}  // namespace isthmus::readers
