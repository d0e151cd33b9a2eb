// Connections: silent ones cost the server no file, closed ones cost nothing else, and those beyond
// the limit are closed.
#include "server/rpc/listener.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <unistd.h>

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "core/concurrency/mutex.h"
#include "tests/server/rpc/rpc_fixture.h"

namespace isthmus::rpc {
namespace {

class Connection {
 public:
  explicit Connection(int port, int family = AF_INET)
      : file_(socket(family, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
    sockaddr_in v4 = {};
    v4.sin_family = AF_INET;
    v4.sin_port = htons(static_cast<uint16_t>(port));
    v4.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    sockaddr_in6 v6 = {};
    v6.sin6_family = AF_INET6;
    v6.sin6_port = v4.sin_port;
    v6.sin6_addr = in6addr_loopback;
    is_open_ = family == AF_INET
                   ? connect(file_, reinterpret_cast<sockaddr*>(&v4), sizeof(v4)) == 0
                   : connect(file_, reinterpret_cast<sockaddr*>(&v6), sizeof(v6)) == 0;
  }
  ~Connection() { close(file_); }
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;

  bool is_open() const { return is_open_; }
  // As a client of HTTP/2 begins.
  void Say() const {
    const std::string hello("PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n\0\0\0\4\0\0\0\0\0", 33);
    EXPECT_EQ(send(file_, hello.data(), hello.size(), MSG_NOSIGNAL), 33);
  }
  // True if it is answered.
  bool Speak() const {
    Say();
    return Received() == 1;
  }
  bool WaitUntilClosed() const { return Received() <= 0; }

 private:
  // As recv of the first byte says; 2 if nothing comes.
  ssize_t Received() const {
    pollfd wanted = {file_, POLLIN, 0};
    char first = 0;
    return poll(&wanted, 1, 30'000) == 1 ? recv(file_, &first, 1, 0) : 2;
  }

  const int file_;
  bool is_open_ = false;
};

// Connections accepted at the port; this process is client and server.
int Accepted(int port) {
  int accepted = 0;
  for (const auto& entry : std::filesystem::directory_iterator("/proc/self/fd")) {
    const int file = std::stoi(entry.path().filename().string());
    sockaddr_storage own = {}, peer = {};
    socklen_t size = sizeof(own), peer_size = sizeof(peer);
    if (getsockname(file, reinterpret_cast<sockaddr*>(&own), &size) != 0) continue;
    if (own.ss_family != AF_INET && own.ss_family != AF_INET6) continue;
    // Both families have the port at the same place.
    if (ntohs(reinterpret_cast<const sockaddr_in&>(own).sin_port) != port) continue;
    accepted += getpeername(file, reinterpret_cast<sockaddr*>(&peer), &peer_size) == 0;
  }
  return accepted;
}

using ListenerOfServer = RpcTest;

TEST_F(ListenerOfServer, WhoSaysNothingHoldsNoFileUntilItSpeaks) {
  std::vector<std::unique_ptr<Connection>> silent(20);
  for (auto& connection : silent) connection = std::make_unique<Connection>(server_->port());
  // Connections are accepted in order, so those before this one had their turn.
  EXPECT_EQ(stubs_->NewSession("alice"), "alice-1");
  EXPECT_EQ(Accepted(server_->port()), 1);
  EXPECT_TRUE(silent[7]->Speak());
  EXPECT_EQ(Accepted(server_->port()), 2);
}

// A listener whose connections are kept by the test.
class ListenerTest : public testing::Test {
 protected:
  ~ListenerTest() override {
    listener_.reset();
    for (const int socket : taken_) close(socket);
  }
  void Listen(const std::string& at, const Listener::Limits& limits) {
    auto opened = Listener::Open(at);
    ASSERT_TRUE(opened.ok()) << opened.status();
    listener_ = *std::move(opened);
    listener_->Start(limits, [this](int, int socket) {
      MutexLock lock(&mutex_);
      taken_.push_back(socket);
      changed_.SignalAll();
    });
  }
  void WaitUntilTaken(size_t count) {
    MutexLock lock(&mutex_);
    while (taken_.size() < count) changed_.Wait(&mutex_);
  }
  size_t taken() {
    MutexLock lock(&mutex_);
    return taken_.size();
  }

  // As gRPC closes one when its client has gone.
  void CloseOneTaken() {
    MutexLock lock(&mutex_);
    close(taken_.front());
    taken_.erase(taken_.begin());
  }

  Mutex mutex_;
  CondVar changed_;
  std::vector<int> taken_ ABSL_GUARDED_BY(mutex_);
  std::unique_ptr<Listener> listener_;
};

constexpr Listener::Limits kMany = {100'000, 100'000};

TEST_F(ListenerTest, OneThatWasClosedIsNotTaken) {
  Listen("127.0.0.1:0", kMany);
  for (int i = 0; i < 50; ++i) Connection(listener_->port());
  const Connection last(listener_->port());
  last.Say();
  WaitUntilTaken(1);
  EXPECT_EQ(taken(), 1u);
  EXPECT_EQ(listener_->refused(), 0u);
}

TEST_F(ListenerTest, BeyondTheLimitTheyAreClosedAtOnce) {
  Listen("127.0.0.1:0", {100'000, 0});
  for (int i = 0; i < 5; ++i) {
    const Connection one(listener_->port());
    one.Say();
    EXPECT_TRUE(one.WaitUntilClosed());
  }
  EXPECT_EQ(listener_->refused(), 5u);
  EXPECT_EQ(taken(), 0u);
}

// The files that the process has open beside them, here a hundred, count for nothing.
TEST_F(ListenerTest, OnlyConnectionsCountAndOnlyWhileTheyAreOpen) {
  std::vector<int> others(100);
  for (int& file : others) file = dup(STDIN_FILENO);
  Listen("127.0.0.1:0", {2, 100'000});
  const Connection first(listener_->port()), second(listener_->port());
  first.Say();
  second.Say();
  WaitUntilTaken(2);
  const Connection refused(listener_->port());
  refused.Say();
  EXPECT_TRUE(refused.WaitUntilClosed());
  EXPECT_EQ(listener_->refused(), 1u);
  CloseOneTaken();
  const Connection third(listener_->port());
  third.Say();
  WaitUntilTaken(2);
  const Connection again(listener_->port());
  again.Say();
  EXPECT_TRUE(again.WaitUntilClosed());
  EXPECT_EQ(listener_->refused(), 2u);
  for (const int file : others) close(file);
}

// gRPC's own listener never listens again after that.
TEST_F(ListenerTest, WithoutAnyFileLeftItRefusesAndThenGoesOn) {
  Listen("127.0.0.1:0", kMany);
  const Connection refused(listener_->port()), later(listener_->port());
  rlimit limit = {};
  ASSERT_EQ(getrlimit(RLIMIT_NOFILE, &limit), 0);
  std::vector<int> files;
  const rlimit few = {128, limit.rlim_max};
  ASSERT_EQ(setrlimit(RLIMIT_NOFILE, &few), 0);
  for (int file = 0; (file = dup(0)) >= 0;) files.push_back(file);
  refused.Say();
  EXPECT_TRUE(refused.WaitUntilClosed());
  for (const int file : files) close(file);
  ASSERT_EQ(setrlimit(RLIMIT_NOFILE, &limit), 0);
  later.Say();
  WaitUntilTaken(1);
  EXPECT_EQ(listener_->refused(), 1u);
}

TEST_F(ListenerTest, AllAddressesAreThoseOfBothFamilies) {
  for (const char* all : {"0.0.0.0:0", "[::]:0"}) {
    Listen(all, kMany);
    const size_t before = taken();
    Connection(listener_->port()).Say();
    WaitUntilTaken(before + 1);
    const Connection v6(listener_->port(), AF_INET6);
    if (!v6.is_open()) GTEST_SKIP() << "this machine has no IPv6";
    v6.Say();
    WaitUntilTaken(before + 2);
  }
}

TEST_F(ListenerTest, OnceStoppedNobodyListensThere) {
  Listen("127.0.0.1:0", kMany);
  const int port = listener_->port();
  listener_->Stop();
  EXPECT_FALSE(Connection(port).is_open());
}

TEST_F(ListenerTest, OneAddressIsListenedAtOnce) {
  Listen("localhost:0", kMany);
  const auto second = Listener::Open("localhost:" + std::to_string(listener_->port()));
  EXPECT_TRUE(absl::IsUnavailable(second.status())) << second.status();
  EXPECT_TRUE(absl::IsUnavailable(Listener::Open("nowhere.invalid:0").status()));
  EXPECT_TRUE(absl::IsUnavailable(Listener::Open("192.0.2.1:0").status()));  // Documentation's.
}

}  // namespace
}  // namespace isthmus::rpc
