#include "client/readers/packets/live/udp_uri.h"

#include <absl/strings/numbers.h>
#include <absl/strings/str_cat.h>
#include <absl/strings/string_view.h>
#include <absl/strings/strip.h>
#include <arpa/inet.h>
#include <net/if.h>
#include <netinet/in.h>

#include <cstring>

namespace isthmus::readers::live {
namespace {

absl::Status BadUri(const std::string& uri, absl::string_view what) {
  return absl::InvalidArgumentError(
      absl::StrCat(uri, ": ", what,
                   "; a live sensor is udp://:2368, udp://192.168.1.100:2368, "
                   "udp://239.0.0.1:2368 or udp://[fe80::1%eth0]:7502"));
}

bool SetIpv4(const std::string& text, uint16_t port, UdpUri& result) {
  sockaddr_in address = {};
  address.sin_family = AF_INET;
  address.sin_port = htons(port);
  if (inet_pton(AF_INET, text.c_str(), &address.sin_addr) != 1) return false;
  result.multicast = IN_MULTICAST(ntohl(address.sin_addr.s_addr));
  result.size = sizeof(address);
  std::memcpy(&result.address, &address, sizeof(address));
  return true;
}

bool SetIpv6(const std::string& text, uint16_t port, UdpUri& result) {
  sockaddr_in6 address = {};
  address.sin6_family = AF_INET6;
  address.sin6_port = htons(port);
  const size_t percent = text.find('%');
  if (inet_pton(AF_INET6, text.substr(0, percent).c_str(), &address.sin6_addr) != 1) return false;
  if (percent != std::string::npos) {
    address.sin6_scope_id = if_nametoindex(text.substr(percent + 1).c_str());
    if (address.sin6_scope_id == 0) return false;
  }
  result.multicast = IN6_IS_ADDR_MULTICAST(&address.sin6_addr);
  result.size = sizeof(address);
  std::memcpy(&result.address, &address, sizeof(address));
  return true;
}

}  // namespace

absl::StatusOr<UdpUri> ParseUdpUri(const std::string& uri) {
  absl::string_view rest = uri;
  if (!absl::ConsumePrefix(&rest, "udp://")) return BadUri(uri, "it does not begin with udp://");
  const size_t colon = rest.rfind(':');
  uint32_t port = 0;
  if (colon == absl::string_view::npos || !absl::SimpleAtoi(rest.substr(colon + 1), &port) ||
      port == 0 || port > 65535) {
    return BadUri(uri, "it has no port from 1 to 65535");
  }
  UdpUri result;
  result.port = static_cast<uint16_t>(port);
  const std::string address(rest.substr(0, colon));
  result.any = address.empty();
  if (result.any) {
    SetIpv6("::", result.port, result);
    return result;
  }
  const bool bracketed = address.size() > 2 && address.front() == '[' && address.back() == ']';
  const bool known = bracketed ? SetIpv6(address.substr(1, address.size() - 2), result.port, result)
                               : SetIpv4(address, result.port, result);
  if (!known) {
    return BadUri(uri, absl::StrCat("\"", address, "\" is no address, or of no interface here"));
  }
  return result;
}

}  // namespace isthmus::readers::live
