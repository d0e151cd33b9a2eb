#include "client/readers/messages/decode/packet_message.h"

#include "client/readers/messages/decode/message_fields.h"

namespace isthmus::readers {
namespace {

constexpr size_t kVelodyneDataBytes = 1206;  // Format: of every Velodyne packet.

}  // namespace

absl::StatusOr<std::vector<MessagePacket>> DecodeVelodyneScan(absl::string_view encoding,
                                                              absl::string_view bytes,
                                                              int64_t log_ns) {
  absl::StatusOr<FieldReader> reader = OpenFields(encoding, bytes);
  if (!reader.ok()) return reader.status();
  const MessageHeader header = ReadHeader(*reader);
  const uint32_t count = reader->ReadCount(8 + kVelodyneDataBytes);
  std::vector<MessagePacket> packets;
  for (uint32_t i = 0; i < count; ++i) {
    const int64_t stamp_ns = ReadStamp(*reader);
    packets.push_back(
        {stamp_ns == 0 ? log_ns : stamp_ns, reader->ReadBytes(kVelodyneDataBytes), header.frame});
  }
  if (!reader->ok()) return TooShort("VelodyneScan");
  return packets;
}

absl::StatusOr<std::vector<MessagePacket>> DecodeOusterPacket(absl::string_view encoding,
                                                              absl::string_view bytes,
                                                              int64_t log_ns) {
  absl::StatusOr<FieldReader> reader = OpenFields(encoding, bytes);
  if (!reader.ok()) return reader.status();
  const uint32_t size = reader->ReadCount(1);
  std::vector<MessagePacket> packets = {{log_ns, reader->ReadBytes(size), {}}};
  if (!reader->ok()) return TooShort("PacketMsg");
  return packets;
}

}  // namespace isthmus::readers
