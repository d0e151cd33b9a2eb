// Connections that say nothing: they cost the server no file, and are served once they speak.
#include "core/io/deferred_accept.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <filesystem>
#include <string>
#include <vector>

#include "tests/server/rpc/rpc_fixture.h"

namespace isthmus::rpc {
namespace {

class SilentConnection {
 public:
  explicit SilentConnection(int port) : file_(socket(AF_INET, SOCK_STREAM, 0)) {
    sockaddr_in address = {};
    address.sin_family = AF_INET;
    address.sin_port = htons(static_cast<uint16_t>(port));
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    EXPECT_EQ(connect(file_, reinterpret_cast<sockaddr*>(&address), sizeof(address)), 0);
  }
  ~SilentConnection() { close(file_); }
  SilentConnection(const SilentConnection&) = delete;
  SilentConnection& operator=(const SilentConnection&) = delete;

  // As a client of HTTP/2 begins; true if it is answered.
  bool Speak() const {
    const std::string hello("PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n\0\0\0\4\0\0\0\0\0", 33);
    EXPECT_EQ(send(file_, hello.data(), hello.size(), MSG_NOSIGNAL), 33);
    pollfd wanted = {file_, POLLIN, 0};
    char first = 0;
    return poll(&wanted, 1, 30'000) == 1 && recv(file_, &first, 1, 0) == 1;
  }

 private:
  const int file_;
};

// Of this process, which is client and server: connections that were accepted at the port.
int Accepted(int port) {
  int accepted = 0;
  for (const auto& entry : std::filesystem::directory_iterator("/proc/self/fd")) {
    const int file = std::stoi(entry.path().filename().string());
    sockaddr_storage own = {}, peer = {};
    socklen_t size = sizeof(own), peer_size = sizeof(peer);
    if (getsockname(file, reinterpret_cast<sockaddr*>(&own), &size) != 0) continue;
    if (own.ss_family != AF_INET && own.ss_family != AF_INET6) continue;
    // Of both families at the same place.
    if (ntohs(reinterpret_cast<const sockaddr_in&>(own).sin_port) != port) continue;
    accepted += getpeername(file, reinterpret_cast<sockaddr*>(&peer), &peer_size) == 0;
  }
  return accepted;
}

using DeferredAccept = RpcTest;

TEST_F(DeferredAccept, WhoSaysNothingHoldsNoFileUntilItSpeaks) {
  std::vector<std::unique_ptr<SilentConnection>> silent(20);
  for (auto& connection : silent) connection = std::make_unique<SilentConnection>(server_->port());
  // Connections are accepted in order, so those before this one had their turn.
  EXPECT_EQ(stubs_->NewSession("alice"), "alice-1");
  EXPECT_EQ(Accepted(server_->port()), 1);
  EXPECT_TRUE(silent[7]->Speak());
  EXPECT_EQ(Accepted(server_->port()), 2);
}

TEST_F(DeferredAccept, FindsTheListenersOfThatPortAlone) {
  EXPECT_GE(io::DeferAccept(server_->port()), 1);
  const SilentConnection client(server_->port());
  EXPECT_EQ(io::DeferAccept(0), 0);
}

}  // namespace
}  // namespace isthmus::rpc
