#include <utility>

#include "client/readers/messages/decode/cloud_message.h"
#include "core/codec/column.h"
#include "core/codec/payload_layout.h"

namespace isthmus::readers {
namespace {

constexpr size_t kLivoxPointBytes = 4 + 3 * 4 + 3;  // Format: of a point, without padding.
constexpr uint32_t kLivoxStride = 24;               // Layout: of what it becomes.

}  // namespace

absl::StatusOr<CloudMessage> DecodeLivox(absl::string_view encoding, absl::string_view bytes) {
  absl::StatusOr<FieldReader> opened = OpenFields(encoding, bytes);
  if (!opened.ok()) return opened.status();
  FieldReader& reader = *opened;
  CloudMessage cloud;
  cloud.header = ReadHeader(reader);
  reader.Read<uint64_t>();  // Time of the first point, which is the header's stamp.
  reader.Read<uint32_t>();  // Number of points, as below.
  reader.Skip(1 + 3);       // Number of the LiDAR, reserved.
  const uint32_t count = reader.ReadCount(kLivoxPointBytes);
  PointPayload& payload = cloud.payload;
  payload.width = count;
  payload.stride = kLivoxStride;
  payload.fields = {{"x", 0, ScalarType::kFloat32},    {"y", 4, ScalarType::kFloat32},
                    {"z", 8, ScalarType::kFloat32},    {"intensity", 12, ScalarType::kFloat32},
                    {"time", 16, ScalarType::kUint32}, {"ring", 20, ScalarType::kUint16},
                    {"tag", 22, ScalarType::kUint8}};
  payload.data.resize(size_t{count} * kLivoxStride);
  for (uint32_t i = 0; i < count; ++i) {
    char* const out = payload.data.data() + size_t{i} * kLivoxStride;
    codec::StoreAs(reader.Read<uint32_t>(), out + 16);
    for (size_t axis = 0; axis < 3; ++axis) codec::StoreAs(reader.Read<float>(), out + 4 * axis);
    codec::StoreAs(static_cast<float>(reader.Read<uint8_t>()), out + 12);
    codec::StoreAs(reader.Read<uint8_t>(), out + 22);
    codec::StoreAs(uint16_t{reader.Read<uint8_t>()}, out + 20);
  }
  if (!reader.ok()) return TooShort("CustomMsg");
  if (absl::Status status = codec::CheckLayout(payload); !status.ok()) return status;
  return cloud;
}

}  // namespace isthmus::readers
