#include "lab/loadgen/relay.h"

#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <chrono>

#include "lab/loadgen/dial.h"

namespace isthmus::loadgen {
namespace {

// Answers each connection with what it is sent, until that ends.
class Echo {
 public:
  Echo() : listener_(socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
    sockaddr_in address = {};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof(address);
    auto* raw = reinterpret_cast<sockaddr*>(&address);
    if (bind(listener_, raw, size) != 0 || listen(listener_, 8) != 0) std::abort();
    getsockname(listener_, raw, &size);
    address_ = "127.0.0.1:" + std::to_string(ntohs(address.sin_port));
    thread_ = std::thread([this] { Run(); });
  }
  ~Echo() {
    shutdown(listener_, SHUT_RDWR);
    thread_.join();
    close(listener_);
  }
  const std::string& address() const { return address_; }

 private:
  void Run() {
    for (int one = 0; (one = accept(listener_, nullptr, nullptr)) >= 0; close(one)) {
      char bytes[4096];
      for (ssize_t count = 0; (count = recv(one, bytes, sizeof(bytes), 0)) > 0;) {
        send(one, bytes, static_cast<size_t>(count), MSG_NOSIGNAL);
      }
    }
  }
  const int listener_;
  std::string address_;
  std::thread thread_;
};

// The part of `text` that comes back; less if the connection ends.
std::string SendAndReceive(int socket, const std::string& text) {
  std::thread sender([&] { send(socket, text.data(), text.size(), MSG_NOSIGNAL); });
  std::string back(text.size(), '\0');
  const ssize_t count = recv(socket, back.data(), back.size(), MSG_WAITALL);
  sender.join();
  back.resize(static_cast<size_t>(std::max<ssize_t>(count, 0)));
  return back;
}

std::string Text(size_t size) {
  std::string text(size, ' ');
  for (size_t i = 0; i < size; ++i) text[i] = static_cast<char>('a' + i * i % 26);
  return text;
}

TEST(Relay, CarriesEverythingInOrder) {
  const Echo echo;
  const auto relay = Relay::Open(echo.address(), {.jitter_s = 0.003}, 1);
  ASSERT_TRUE(relay.ok()) << relay.status();
  const int socket = Dial((*relay)->address());
  ASSERT_GE(socket, 0);
  const std::string text = Text(2'000'000);
  EXPECT_EQ(SendAndReceive(socket, text), text);
  EXPECT_EQ((*relay)->bytes_up(), 2'000'000);
  close(socket);
}

TEST(Relay, TakesItsTime) {
  const Echo echo;
  const LinkProfile profile{.delay_s = 0.02, .up_bytes_s = 1e6};
  const auto relay = Relay::Open(echo.address(), profile, 1);
  ASSERT_TRUE(relay.ok()) << relay.status();
  const int socket = Dial((*relay)->address());
  const auto start = std::chrono::steady_clock::now();
  EXPECT_EQ(SendAndReceive(socket, Text(100'000)).size(), 100'000u);
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - start;
  EXPECT_GE(took.count(), 2 * 0.02 + 100'000 / 1e6);  // There and back, and at that rate.
  close(socket);
}

TEST(Relay, LosesConnectionsAndTakesOthers) {
  const Echo echo;
  const auto relay = Relay::Open(echo.address(), {.reset_every_s = 0.05}, 1);
  ASSERT_TRUE(relay.ok()) << relay.status();
  for (int i = 0; i < 2; ++i) {
    const int socket = Dial((*relay)->address());
    ASSERT_GE(socket, 0);
    char byte = 0;
    EXPECT_LE(recv(socket, &byte, 1, 0), 0);  // Returns with the reset.
    close(socket);
  }
  EXPECT_GE((*relay)->resets(), 2);
}

TEST(Relay, RefusesWhatIsNoAddress) {
  EXPECT_TRUE(absl::IsInvalidArgument(Relay::Open("nowhere", {}, 1).status()));
}

TEST(LinkProfile, NamesWhatThereIs) {
  EXPECT_TRUE(FindLinkProfile("none")->is_perfect());
  EXPECT_FALSE(FindLinkProfile("4g")->is_perfect());
  EXPECT_THAT(FindLinkProfile("5g").status().message(), testing::HasSubstr("wifi"));
}

}  // namespace
}  // namespace isthmus::loadgen
