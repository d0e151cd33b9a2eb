#include "lab/loadgen/dial.h"

#include <netdb.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <string_view>

namespace isthmus::loadgen {
namespace {

int DialUnix(const std::string& path) {
  sockaddr_un address = {};
  address.sun_family = AF_UNIX;
  path.copy(address.sun_path, sizeof(address.sun_path) - 1);
  const int server = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  if (connect(server, reinterpret_cast<sockaddr*>(&address), sizeof(address)) == 0) return server;
  close(server);
  return -1;
}

int DialTcp(const std::string& host_port) {
  const size_t colon = host_port.rfind(':');
  if (colon == std::string::npos) return -1;
  std::string host = host_port.substr(0, colon);
  if (host.size() > 2 && host.front() == '[') host = host.substr(1, host.size() - 2);
  addrinfo hints = {};
  hints.ai_socktype = SOCK_STREAM;
  addrinfo* found = nullptr;
  if (getaddrinfo(host.c_str(), host_port.substr(colon + 1).c_str(), &hints, &found) != 0) {
    return -1;
  }
  int server = -1;
  for (const addrinfo* one = found; one != nullptr && server < 0; one = one->ai_next) {
    server = socket(one->ai_family, SOCK_STREAM | SOCK_CLOEXEC, 0);
    if (connect(server, one->ai_addr, one->ai_addrlen) == 0) break;
    close(server);
    server = -1;
  }
  freeaddrinfo(found);
  return server;
}

}  // namespace

int Dial(const std::string& server) {
  constexpr std::string_view kUnix = "unix:";
  return server.starts_with(kUnix) ? DialUnix(server.substr(kUnix.size())) : DialTcp(server);
}

void HangUp(int socket) {
  const linger at_once = {1, 0};
  setsockopt(socket, SOL_SOCKET, SO_LINGER, &at_once, sizeof(at_once));
  close(socket);
}

}  // namespace isthmus::loadgen
