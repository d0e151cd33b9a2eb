#include "server/http/listening_socket.h"

#include <absl/cleanup/cleanup.h>
#include <absl/strings/str_cat.h>
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <utility>

#include "server/http/limits.h"

namespace isthmus::http {
namespace {

absl::Status SystemSays(int error) { return absl::UnavailableError(std::strerror(error)); }

int PortOf(int file) {
  sockaddr_storage bound = {};
  socklen_t size = sizeof(bound);
  if (getsockname(file, reinterpret_cast<sockaddr*>(&bound), &size) != 0) return 0;
  const bool is_old = bound.ss_family == AF_INET;
  return ntohs(is_old ? reinterpret_cast<const sockaddr_in&>(bound).sin_port
                      : reinterpret_cast<const sockaddr_in6&>(bound).sin6_port);
}

absl::StatusOr<ListeningSocket> ListenAtOne(const addrinfo& address) {
  const int file = socket(address.ai_family, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (file < 0) return SystemSays(errno);
  absl::Cleanup closes = [file] { close(file); };
  const int yes = 1, no = 0;
  setsockopt(file, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof(yes));
  if (address.ai_family == AF_INET6) {
    setsockopt(file, IPPROTO_IPV6, IPV6_V6ONLY, &no, sizeof(no));
  }
  setsockopt(file, IPPROTO_TCP, TCP_DEFER_ACCEPT, &kDeferS, sizeof(kDeferS));
  if (bind(file, address.ai_addr, address.ai_addrlen) != 0 || listen(file, kBacklog) != 0) {
    return SystemSays(errno);
  }
  std::move(closes).Cancel();
  return ListeningSocket{file, PortOf(file)};
}

}  // namespace

absl::StatusOr<ListeningSocket> ListenAt(const std::string& address) {
  const size_t colon = address.rfind(':');
  std::string host = address.substr(0, colon);
  if (host.starts_with('[') && host.ends_with(']')) host = host.substr(1, host.size() - 2);
  if (host == "localhost") host = "127.0.0.1";  // Whatever else the machine calls so.
  addrinfo hints = {};
  hints.ai_socktype = SOCK_STREAM;
  hints.ai_flags = AI_PASSIVE | AI_NUMERICSERV;
  addrinfo* found = nullptr;
  const int error = getaddrinfo(host.c_str(), address.substr(colon + 1).c_str(), &hints, &found);
  if (error != 0) return absl::UnavailableError(gai_strerror(error));
  const absl::Cleanup frees = [found] { freeaddrinfo(found); };
  absl::StatusOr<ListeningSocket> last = absl::UnavailableError("no such address");
  for (const addrinfo* one = found; one != nullptr; one = one->ai_next) {
    last = ListenAtOne(*one);
    if (last.ok()) break;
  }
  return last;
}

}  // namespace isthmus::http
