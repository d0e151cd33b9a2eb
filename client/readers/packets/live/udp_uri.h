// The address that a live sensor sends to.
#pragma once

#include <absl/status/statusor.h>
#include <sys/socket.h>

#include <cstdint>
#include <string>

namespace isthmus::readers::live {

struct UdpUri {
  sockaddr_storage address = {};  // With the port.
  socklen_t size = 0;
  bool multicast = false;
  uint16_t port = 0;
  bool any = true;  // No address was given: all interfaces, IPv4 and IPv6.
};

// udp://[ADDRESS]:PORT with a literal IPv4 address, or an IPv6 one in brackets, with %INTERFACE if
// it is link-local; no address stands for all interfaces. InvalidArgument for anything else.
absl::StatusOr<UdpUri> ParseUdpUri(const std::string& uri);

}  // namespace isthmus::readers::live
