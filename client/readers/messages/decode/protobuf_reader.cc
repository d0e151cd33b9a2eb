#include "client/readers/messages/decode/protobuf_reader.h"

#include <cstring>

namespace isthmus::readers {

uint64_t ProtobufReader::ReadVarint() {
  uint64_t value = 0;
  for (int shift = 0; shift < 64; shift += 7) {
    const absl::string_view byte = Take(1);
    if (!ok_) return 0;
    value |= uint64_t{static_cast<uint8_t>(byte[0]) & 0x7Fu} << shift;
    if ((byte[0] & 0x80) == 0) return value;
  }
  ok_ = false;
  return 0;
}

absl::string_view ProtobufReader::Take(uint64_t size) {
  ok_ = ok_ && size <= rest_.size();
  if (!ok_) return {};
  const absl::string_view bytes = rest_.substr(0, size);
  rest_.remove_prefix(size);
  return bytes;
}

uint64_t ProtobufReader::ReadFixed(uint64_t size) {
  const absl::string_view bytes = Take(size);
  uint64_t value = 0;
  if (ok_) std::memcpy(&value, bytes.data(), size);
  return value;
}

bool ProtobufReader::Next(ProtobufField& field) {
  if (rest_.empty()) return false;
  const uint64_t tag = ReadVarint();
  field = {static_cast<uint32_t>(tag >> 3), 0, {}};
  switch (tag & 7) {
    case 0:
      field.value = ReadVarint();
      break;
    case 1:
      field.value = ReadFixed(8);
      break;
    case 2:
      field.bytes = Take(ReadVarint());
      break;
    case 5:
      field.value = ReadFixed(4);
      break;
    default:
      ok_ = false;
  }
  return ok_;
}

}  // namespace isthmus::readers
