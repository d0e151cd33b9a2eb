#include "client/readers/packets/capture/datagram.h"

#include <arpa/inet.h>
#include <pcap/dlt.h>

#include <algorithm>
#include <cstring>

namespace isthmus::readers::capture {
namespace {

constexpr uint16_t kIpv4Type = 0x0800;  // Format
constexpr uint16_t kIpv6Type = 0x86DD;  // Format
constexpr uint8_t kUdpProtocol = 17;    // Format
// IPv6's extension headers that may come before UDP.
constexpr uint8_t kHopByHop = 0, kRouting = 43, kFragment = 44, kDestination = 60;  // Format
constexpr int kMaxTags = 4;        // Format: VLAN tags in one frame.
constexpr int kMaxExtensions = 8;  // Format: that IPv6 knows.

uint8_t Byte(absl::string_view bytes, size_t at) { return static_cast<uint8_t>(bytes[at]); }
uint16_t BigEndian16(absl::string_view bytes, size_t at) {
  return static_cast<uint16_t>(Byte(bytes, at) << 8 | Byte(bytes, at + 1));
}
uint32_t BigEndian32(absl::string_view bytes, size_t at) {
  return static_cast<uint32_t>(BigEndian16(bytes, at)) << 16 | BigEndian16(bytes, at + 2);
}

IpAddress AddressAt(absl::string_view bytes, size_t at, bool v6) {
  IpAddress address;
  address.v6 = v6;
  std::memcpy(address.bytes.data(), bytes.data() + at, v6 ? 16 : 4);
  return address;
}

std::optional<IpPacket> ParseIpv4(absl::string_view bytes) {
  if (bytes.size() < 20) return std::nullopt;
  const size_t header = size_t{Byte(bytes, 0) & 0x0Fu} * 4;
  const size_t total = BigEndian16(bytes, 2);
  if (header < 20 || bytes.size() < header || total < header) return std::nullopt;
  IpPacket packet;
  packet.source = AddressAt(bytes, 12, false);
  packet.destination = AddressAt(bytes, 16, false);
  packet.protocol = Byte(bytes, 9);
  packet.length = total - header;
  packet.payload = bytes.substr(header, packet.length);  // Without what pads the frame.
  const uint16_t flags = BigEndian16(bytes, 6);
  packet.id = BigEndian16(bytes, 4);
  packet.offset = (flags & 0x1FFFu) * 8;
  packet.more = (flags & 0x2000u) != 0;
  packet.fragment = packet.more || packet.offset > 0;
  return packet;
}

std::optional<IpPacket> ParseIpv6(absl::string_view bytes) {
  if (bytes.size() < 40) return std::nullopt;
  IpPacket packet;
  packet.source = AddressAt(bytes, 8, true);
  packet.destination = AddressAt(bytes, 24, true);
  packet.protocol = Byte(bytes, 6);
  packet.length = BigEndian16(bytes, 4);
  packet.payload = bytes.substr(40, packet.length);
  for (int i = 0; i < kMaxExtensions; ++i) {
    size_t size = 0;
    if (packet.protocol == kFragment) {
      size = 8;
    } else if (packet.protocol == kHopByHop || packet.protocol == kRouting ||
               packet.protocol == kDestination) {
      if (packet.payload.size() < 8) return std::nullopt;
      size = 8 + size_t{Byte(packet.payload, 1)} * 8;
    } else {
      return packet;
    }
    if (packet.payload.size() < size || packet.length < size) return std::nullopt;
    if (packet.protocol == kFragment) {
      const uint16_t place = BigEndian16(packet.payload, 2);
      packet.offset = place & 0xFFF8u;
      packet.more = (place & 1u) != 0;
      packet.id = BigEndian32(packet.payload, 4);
      packet.fragment = packet.more || packet.offset > 0;
    }
    packet.protocol = Byte(packet.payload, 0);
    packet.payload.remove_prefix(size);
    packet.length -= size;
  }
  return std::nullopt;
}

std::optional<IpPacket> ParseIp(absl::string_view bytes) {
  if (bytes.empty()) return std::nullopt;
  const int version = Byte(bytes, 0) >> 4;
  if (version == 4) return ParseIpv4(bytes);
  return version == 6 ? ParseIpv6(bytes) : std::nullopt;
}

// `at`: where the EtherType is, behind which the payload or VLAN tags come.
std::optional<IpPacket> ParseTyped(absl::string_view frame, size_t at) {
  for (int tag = 0; tag <= kMaxTags; ++tag, at += 4) {
    if (frame.size() < at + 2) return std::nullopt;
    const uint16_t type = BigEndian16(frame, at);
    if (type == kIpv4Type || type == kIpv6Type) return ParseIp(frame.substr(at + 2));
    const bool tagged = type == 0x8100 || type == 0x88A8 || type == 0x9100;
    if (!tagged) return std::nullopt;
  }
  return std::nullopt;
}

}  // namespace

std::string IpAddress::Text() const {
  char text[INET6_ADDRSTRLEN] = {};
  inet_ntop(v6 ? AF_INET6 : AF_INET, bytes.data(), text, sizeof(text));
  return text;
}

bool IsKnownLink(int link_type) {
  switch (link_type) {
    case DLT_EN10MB:
    case DLT_LINUX_SLL:
    case DLT_LINUX_SLL2:
    case DLT_NULL:
    case DLT_LOOP:
    case DLT_RAW:
    case DLT_IPV4:
    case DLT_IPV6:
      return true;
    default:
      return false;
  }
}

std::optional<IpPacket> ParseFrame(int link_type, absl::string_view frame) {
  switch (link_type) {
    case DLT_EN10MB:
      return ParseTyped(frame, 12);
    case DLT_LINUX_SLL:
      return ParseTyped(frame, 14);
    case DLT_LINUX_SLL2:
      if (frame.size() < 20) return std::nullopt;
      if (BigEndian16(frame, 0) != 0x8100) return ParseIp(frame.substr(20));
      return ParseTyped(frame, 20 + 2);
    case DLT_NULL:
    case DLT_LOOP:
      return frame.size() < 4 ? std::nullopt : ParseIp(frame.substr(4));
    case DLT_RAW:
    case DLT_IPV4:
    case DLT_IPV6:
      return ParseIp(frame);
    default:
      return std::nullopt;
  }
}

std::optional<Datagram> ParseUdp(const IpPacket& packet) {
  if (packet.protocol != kUdpProtocol || packet.offset != 0 || packet.payload.size() < 8) {
    return std::nullopt;
  }
  Datagram datagram;
  datagram.source = packet.source;
  datagram.source_port = BigEndian16(packet.payload, 0);
  datagram.port = BigEndian16(packet.payload, 2);
  const size_t length = BigEndian16(packet.payload, 4);
  if (length < 8 || (!packet.fragment && length > packet.length)) return std::nullopt;
  datagram.length = length - 8;
  datagram.payload = packet.payload.substr(8, std::min(datagram.length, packet.payload.size()));
  return datagram;
}

}  // namespace isthmus::readers::capture
