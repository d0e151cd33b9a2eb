#include "client/readers/messages/decode/packet_message.h"

#include "client/readers/messages/decode/message_fields.h"

namespace isthmus::readers {
namespace {

// The layout of a packet in a list.
struct PacketLayout {
  const char* type;
  bool stamped;
  size_t fixed_bytes;  // Bytes of data; 0: their number comes before them.
  bool size_behind;    // The number of data bytes that are the packet's follows them.
};

PacketLayout LayoutOf(PacketList list) {
  switch (list) {
    case PacketList::kVelodyneScan:
      return {"VelodyneScan", true, 1206, false};
    case PacketList::kPandarScan:
      return {"PandarScan", true, 1500, true};
    case PacketList::kNebulaPackets:
      return {"NebulaPackets", true, 0, false};
    case PacketList::kUdpFrame:
      break;
  }
  return {"UdpFrame", false, 0, true};
}

}  // namespace

absl::StatusOr<std::vector<MessagePacket>> DecodePacketList(PacketList list,
                                                            absl::string_view encoding,
                                                            absl::string_view bytes,
                                                            int64_t log_ns) {
  absl::StatusOr<FieldReader> reader = OpenFields(encoding, bytes);
  if (!reader.ok()) return reader.status();
  const PacketLayout layout = LayoutOf(list);
  const MessageHeader header = ReadHeader(*reader);
  const int64_t otherwise_ns = layout.stamped || header.stamp_ns == 0 ? log_ns : header.stamp_ns;
  const uint32_t count = reader->ReadCount((layout.stamped ? 8 : 0) +
                                           (layout.fixed_bytes > 0 ? layout.fixed_bytes : 4));
  std::vector<MessagePacket> packets;
  for (uint32_t i = 0; i < count && reader->ok(); ++i) {
    const int64_t stamp_ns = layout.stamped ? ReadStamp(*reader) : 0;
    const size_t size = layout.fixed_bytes > 0 ? layout.fixed_bytes : reader->ReadCount(1);
    absl::string_view data = reader->ReadBytes(size);
    if (layout.size_behind) data = data.substr(0, reader->Read<uint32_t>());
    packets.push_back({stamp_ns == 0 ? otherwise_ns : stamp_ns, data, header.frame});
  }
  if (!reader->ok()) return TooShort(layout.type);
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
