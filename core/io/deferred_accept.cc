#include "core/io/deferred_accept.h"

#include <absl/strings/numbers.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>

#include <filesystem>
#include <system_error>

namespace isthmus::io {
namespace {

// Longer than any client needs, and what gRPC gives a handshake.
constexpr int kPatienceS = 10;

bool ListensAt(int file, int port) {
  int listens = 0;
  socklen_t size = sizeof(listens);
  if (getsockopt(file, SOL_SOCKET, SO_ACCEPTCONN, &listens, &size) != 0 || !listens) return false;
  sockaddr_storage address = {};
  size = sizeof(address);
  if (getsockname(file, reinterpret_cast<sockaddr*>(&address), &size) != 0) return false;
  if (address.ss_family == AF_INET) {
    return ntohs(reinterpret_cast<const sockaddr_in&>(address).sin_port) == port;
  }
  return address.ss_family == AF_INET6 &&
         ntohs(reinterpret_cast<const sockaddr_in6&>(address).sin6_port) == port;
}

}  // namespace

int DeferAccept(int port) {
  int found = 0;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator("/proc/self/fd", error)) {
    int file = -1;
    if (!absl::SimpleAtoi(entry.path().filename().string(), &file)) continue;
    if (!ListensAt(file, port)) continue;
    found += setsockopt(file, IPPROTO_TCP, TCP_DEFER_ACCEPT, &kPatienceS, sizeof(kPatienceS)) == 0;
  }
  return found;
}

}  // namespace isthmus::io
