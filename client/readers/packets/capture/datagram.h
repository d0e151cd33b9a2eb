// A UDP datagram, and how one is found in a captured frame.
#pragma once

#include <absl/strings/string_view.h>

#include <array>
#include <compare>
#include <cstdint>
#include <optional>
#include <string>

namespace isthmus::readers::capture {

struct IpAddress {
  std::array<uint8_t, 16> bytes = {};  // The first 4 of an IPv4 address.
  bool v6 = false;

  std::string Text() const;  // "192.168.1.201", "fe80::1"
  auto operator<=>(const IpAddress&) const = default;
};

// An IP packet, or a fragment of one. Views into the frame.
struct IpPacket {
  IpAddress source, destination;
  uint8_t protocol = 0;
  absl::string_view payload;  // Behind the IP header; shorter than `length` in cut captures.
  size_t length = 0;          // As the header says.
  // A fragment's packet number, its place in the packet in bytes, and true if more follow.
  bool fragment = false;
  uint32_t id = 0;
  uint32_t offset = 0;
  bool more = false;
};

struct Datagram {
  IpAddress source;
  uint16_t source_port = 0, port = 0;  // To which it was sent: `port`.
  absl::string_view payload;           // Fewer than `length` where only its beginning is there.
  size_t length = 0;
};

// The link layers of pcap that are read: Ethernet (with VLAN tags), Linux cooked captures of both
// versions, loopback, raw IP. `link_type` is libpcap's DLT_ number.
bool IsKnownLink(int link_type);

// The IP packet in a frame; empty for anything else and for what is too short or lies about its
// sizes. RFC 791, RFC 8200 (extension headers), IEEE 802.1Q.
std::optional<IpPacket> ParseFrame(int link_type, absl::string_view frame);

// The datagram in a whole IP packet or in its first fragment; empty for anything else. RFC 768.
// Checksums are not looked at: network cards fill them in behind the capture.
std::optional<Datagram> ParseUdp(const IpPacket& packet);

}  // namespace isthmus::readers::capture
