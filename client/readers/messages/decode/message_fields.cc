#include "client/readers/messages/decode/message_fields.h"

#include <absl/strings/str_cat.h>

namespace isthmus::readers {

absl::StatusOr<FieldReader> OpenFields(absl::string_view encoding, absl::string_view bytes) {
  if (encoding == "ros1") return FieldReader::Plain(bytes);
  if (encoding == "cdr") return FieldReader::Cdr(bytes);
  return absl::InvalidArgumentError(
      absl::StrCat("messages in the encoding '", encoding, "' are not read; ros1 and cdr are"));
}

int64_t ReadStamp(FieldReader& reader) {
  // ROS 2 has signed seconds.
  const int64_t seconds =
      reader.is_cdr() ? int64_t{reader.Read<int32_t>()} : int64_t{reader.Read<uint32_t>()};
  return seconds * 1'000'000'000 + reader.Read<uint32_t>();
}

MessageHeader ReadHeader(FieldReader& reader) {
  if (!reader.is_cdr()) reader.Skip(4);  // ROS 2 has no sequence number.
  MessageHeader header;
  header.stamp_ns = ReadStamp(reader);
  header.frame = std::string(reader.ReadString());
  return header;
}

absl::Status TooShort(absl::string_view type) {
  return absl::InvalidArgumentError(
      absl::StrCat("the message is damaged: it ends before the fields of a ", type, " do"));
}

}  // namespace isthmus::readers
