#include <absl/strings/str_cat.h>

#include <algorithm>
#include <utility>

#include "client/readers/messages/decode/cloud_message.h"
#include "core/codec/payload_layout.h"

namespace isthmus::readers {
namespace {

constexpr size_t kLeastFieldBytes = 4 + 4 + 1 + 4;  // Format: of a PointField without a name.

bool ReadPointFields(FieldReader& reader, PointPayload& payload) {
  const uint32_t count = reader.ReadCount(kLeastFieldBytes);
  if (count > codec::kMaxFields) return false;
  for (uint32_t i = 0; i < count; ++i) {
    PointField field;
    field.name = std::string(reader.ReadString());
    field.offset = reader.Read<uint32_t>();
    field.type = static_cast<ScalarType>(reader.Read<uint8_t>());
    field.count = std::max(1u, reader.Read<uint32_t>());
    if (SizeOf(field.type) > 0) payload.fields.push_back(std::move(field));
  }
  return reader.ok();
}

// Copies the rows without what lies between them.
absl::Status TakeRows(absl::string_view data, uint32_t row_step, PointPayload& payload) {
  const uint64_t row = uint64_t{payload.width} * payload.stride;
  const uint64_t packed = row * payload.height;
  // Drivers that do not pad often leave the step of rows at 0, or at something else.
  const uint64_t step = data.size() == packed ? row : row_step;
  // No more points than bytes: with that none of these products overflows.
  if (codec::PointCount(payload) > data.size() || row == 0 || payload.height == 0 || step < row ||
      packed > codec::kMaxDecodedBytes ||
      step * (payload.height - uint64_t{1}) + row > data.size()) {
    return absl::InvalidArgumentError(absl::StrCat(
        payload.width, " x ", payload.height, " points of ", payload.stride, " bytes in rows of ",
        row_step, " do not make the ", data.size(), " bytes of the message"));
  }
  payload.data.reserve(packed);
  for (uint64_t i = 0; i < payload.height; ++i) payload.data.append(data.data() + i * step, row);
  return absl::OkStatus();
}

void SwapNumbers(PointPayload& payload) {
  for (const PointField& field : payload.fields) {
    const size_t size = SizeOf(field.type);
    for (size_t at = field.offset; at < payload.data.size(); at += payload.stride) {
      for (uint32_t i = 0; i < field.count; ++i) {
        char* const number = payload.data.data() + at + i * size;
        std::reverse(number, number + size);
      }
    }
  }
}

}  // namespace

absl::StatusOr<CloudMessage> DecodePointCloud2(absl::string_view encoding,
                                               absl::string_view bytes) {
  absl::StatusOr<FieldReader> reader = OpenFields(encoding, bytes);
  if (!reader.ok()) return reader.status();
  CloudMessage cloud;
  cloud.header = ReadHeader(*reader);
  PointPayload& payload = cloud.payload;
  payload.height = reader->Read<uint32_t>();
  payload.width = reader->Read<uint32_t>();
  if (!ReadPointFields(*reader, payload)) return TooShort("PointCloud2");
  const bool big_endian = reader->Read<uint8_t>() != 0;
  payload.stride = reader->Read<uint32_t>();
  const auto row_step = reader->Read<uint32_t>();
  const absl::string_view data = reader->ReadBytes(reader->ReadCount(1));
  if (!reader->ok()) return TooShort("PointCloud2");
  if (codec::PointCount(payload) == 0) {
    return absl::InvalidArgumentError("the scan is empty: it has no points");
  }
  if (absl::Status status = TakeRows(data, row_step, payload); !status.ok()) return status;
  if (absl::Status status = codec::CheckLayout(payload); !status.ok()) return status;
  if (big_endian) SwapNumbers(payload);
  return cloud;
}

}  // namespace isthmus::readers
