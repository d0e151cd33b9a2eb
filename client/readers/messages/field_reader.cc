#include "client/readers/messages/field_reader.h"

#include <absl/strings/str_cat.h>

#include "client/readers/messages/limits.h"

namespace isthmus::readers {
namespace {

constexpr size_t kCdrHeaderBytes = 4;  // Format

}  // namespace

absl::StatusOr<FieldReader> FieldReader::Cdr(absl::string_view bytes) {
  if (bytes.size() < kCdrHeaderBytes) {
    return absl::InvalidArgumentError("the message is too short to be CDR");
  }
  const int kind = static_cast<uint8_t>(bytes[0]) << 8 | static_cast<uint8_t>(bytes[1]);
  if (kind > 1) {
    return absl::InvalidArgumentError(absl::StrCat(
        "the message is in representation 0x", absl::Hex(kind, absl::kZeroPad4),
        " of CDR; only plain CDR of version 1 (0x0000, 0x0001), as ROS 2 records it, is read"));
  }
  return FieldReader(bytes.substr(kCdrHeaderBytes), /*aligned=*/true, /*swapped=*/kind == 0);
}

absl::string_view FieldReader::ReadBytes(size_t size) {
  ok_ = ok_ && size <= remaining();
  if (!ok_) return {};
  at_ += size;
  return bytes_.substr(at_ - size, size);
}

absl::string_view FieldReader::ReadString() {
  const auto size = Read<uint32_t>();
  ok_ = ok_ && size <= kMaxStringBytes;
  absl::string_view text = ReadBytes(size);
  if (aligned_ && !text.empty() && text.back() == '\0') text.remove_suffix(1);
  return text;
}

uint32_t FieldReader::ReadCount(size_t least_bytes) {
  const auto count = Read<uint32_t>();
  ok_ = ok_ && count <= remaining() / least_bytes;
  return ok_ ? count : 0;
}

}  // namespace isthmus::readers
