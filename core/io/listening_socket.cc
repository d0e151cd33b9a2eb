#include "core/io/listening_socket.h"

#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>

#include <cerrno>
#include <cstring>
#include <memory>
#include <utility>

namespace isthmus::io {
namespace {

// Longer than any client needs for its first bytes, and what gRPC gives a handshake.
constexpr int kPatienceS = 10;
// Connections that the system holds ready: a second of what a network brings after it was away.
constexpr int kBacklog = 1024;

using Addresses = std::unique_ptr<addrinfo, decltype(&freeaddrinfo)>;

void SetOption(int file, int level, int name, int value) {
  // One that the system has not makes connections slower at worst.
  (void)setsockopt(file, level, name, &value, sizeof(value));
}

// "host", "port" of "host:port" and "[host]:port".
std::pair<std::string, std::string> Split(const std::string& listen) {
  const size_t colon = listen.rfind(':');
  std::string host = listen.substr(0, colon);
  if (host.size() > 1 && host.front() == '[' && host.back() == ']') {
    host = host.substr(1, host.size() - 2);
  }
  return {host, listen.substr(colon + 1)};
}

absl::StatusOr<Addresses> Resolve(const std::string& host, const std::string& port) {
  addrinfo hints = {};
  hints.ai_socktype = SOCK_STREAM;
  hints.ai_flags = AI_PASSIVE | AI_NUMERICSERV;
  addrinfo* found = nullptr;
  const int error = getaddrinfo(host.c_str(), port.c_str(), &hints, &found);
  if (error == 0) return Addresses(found, freeaddrinfo);
  return absl::UnavailableError(gai_strerror(error));
}

void SetPort(sockaddr* address, uint16_t port) {
  const bool is_v6 = address->sa_family == AF_INET6;
  (is_v6 ? reinterpret_cast<sockaddr_in6*>(address)->sin6_port
         : reinterpret_cast<sockaddr_in*>(address)->sin_port) = htons(port);
}

uint16_t PortAt(int file) {
  sockaddr_storage address = {};
  socklen_t size = sizeof(address);
  if (getsockname(file, reinterpret_cast<sockaddr*>(&address), &size) != 0) return 0;
  return ntohs(address.ss_family == AF_INET6
                   ? reinterpret_cast<const sockaddr_in6&>(address).sin6_port
                   : reinterpret_cast<const sockaddr_in&>(address).sin_port);
}

// Not open, with errno, where it cannot.
File ListenAtOne(const addrinfo& at) {
  const int type = SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC;
  File file(socket(at.ai_family, type, 0), "socket", DiskCalls::System());
  if (!file.is_open()) return file;
  const int number = file.descriptor();
  SetOption(number, SOL_SOCKET, SO_REUSEADDR, 1);  // After a restart, while old connections end.
  SetOption(number, IPPROTO_TCP, TCP_NODELAY, 1);  // Accepted sockets inherit these.
  SetOption(number, IPPROTO_TCP, TCP_DEFER_ACCEPT, kPatienceS);
  if (at.ai_family == AF_INET6) {
    const auto& v6 = *reinterpret_cast<const sockaddr_in6*>(at.ai_addr);
    const bool all = IN6_IS_ADDR_UNSPECIFIED(&v6.sin6_addr);
    SetOption(number, IPPROTO_IPV6, IPV6_V6ONLY, all ? 0 : 1);
  }
  const bool listens =
      bind(number, at.ai_addr, at.ai_addrlen) == 0 && listen(number, kBacklog) == 0;
  const int error = errno;
  if (!listens) file = File();
  errno = error;
  return file;
}

// At all addresses of the host.
absl::StatusOr<std::vector<File>> ListenAtHost(const std::string& host, const std::string& port) {
  const absl::StatusOr<Addresses> addresses = Resolve(host, port);
  if (!addresses.ok()) return addresses.status();
  std::vector<File> sockets;
  int error = 0;
  for (const addrinfo* at = addresses->get(); at != nullptr; at = at->ai_next) {
    // Port 0 is the same free one for all.
    if (!sockets.empty()) SetPort(at->ai_addr, PortAt(sockets.front().descriptor()));
    File file = ListenAtOne(*at);
    if (file.is_open()) {
      sockets.push_back(std::move(file));
    } else if (error != EADDRINUSE) {
      error = errno;
    }
  }
  if (!sockets.empty() && error != EADDRINUSE) return sockets;
  return absl::UnavailableError(std::strerror(error));
}

}  // namespace

absl::StatusOr<std::vector<File>> ListenAt(const std::string& address) {
  const auto [host, port] = Split(address);
  if (host != "0.0.0.0" && host != "::") return ListenAtHost(host, port);
  absl::StatusOr<std::vector<File>> both = ListenAtHost("::", port);
  return both.ok() ? std::move(both) : ListenAtHost("0.0.0.0", port);  // There may be no IPv6.
}

int PortOf(const File& socket) { return PortAt(socket.descriptor()); }

}  // namespace isthmus::io
