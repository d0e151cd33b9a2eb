// isthmus-server under a service manager, and with a listener that went deaf.
#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <signal.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <vector>

#include "tests/server/main/child_process.h"

namespace isthmus {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

const char kListening[] = "isthmus-server listening on 127.0.0.1:";

class SupervisionTest : public testing::Test {
 protected:
  SupervisionTest() {
    folder_ = testing::TempDir() + "isthmus-supervision-XXXXXX";
    if (mkdtemp(folder_.data()) == nullptr) throw std::runtime_error("mkdtemp failed");
  }
  ~SupervisionTest() override {
    server_.reset();
    std::filesystem::remove_all(folder_);
  }

  // With so many open files at most. Returns the port.
  int Serve(int files, const std::string& settings) {
    std::ofstream(folder_ + "/server.yaml") << settings;
    server_ = std::make_unique<ChildProcess>(
        "/bin/sh",
        std::vector<std::string>{"-c", "ulimit -n " + std::to_string(files) + "; exec \"$@\"", "sh",
                                 ISTHMUS_SERVER, "--data", folder_ + "/data", "--listen",
                                 "127.0.0.1:0", "--config", folder_ + "/server.yaml"},
        folder_ + "/stderr");
    const std::string line = server_->ReadLine();
    EXPECT_THAT(line, StartsWith(kListening)) << server_->Errors();
    return line.size() < sizeof(kListening) ? 0 : std::stoi(line.substr(sizeof(kListening) - 1));
  }

  std::string folder_;
  std::unique_ptr<ChildProcess> server_;
};

// Where a service manager listens.
class NotifySocket {
 public:
  explicit NotifySocket(const std::string& path) : file_(socket(AF_UNIX, SOCK_DGRAM, 0)) {
    sockaddr_un address = {};
    address.sun_family = AF_UNIX;
    path.copy(address.sun_path, sizeof(address.sun_path) - 1);
    if (bind(file_, reinterpret_cast<sockaddr*>(&address), sizeof(address)) != 0) {
      throw std::runtime_error("bind failed");
    }
    const timeval longest = {60, 0};
    setsockopt(file_, SOL_SOCKET, SO_RCVTIMEO, &longest, sizeof(longest));
    setenv("NOTIFY_SOCKET", path.c_str(), 1);
    setenv("WATCHDOG_USEC", "400000", 1);
  }
  ~NotifySocket() {
    unsetenv("NOTIFY_SOCKET");
    unsetenv("WATCHDOG_USEC");
    close(file_);
  }
  std::string Next() const {
    char text[512];
    const ssize_t size = recv(file_, text, sizeof(text), 0);
    return size < 0 ? "nothing" : std::string(text, static_cast<size_t>(size));
  }

 private:
  const int file_;
};

TEST_F(SupervisionTest, AServiceManagerHearsThatItServesAndThatItEnds) {
  const NotifySocket manager(folder_ + "/notify");
  Serve(1024, "network:\n  listener_watchdog_s: 0\n");
  EXPECT_THAT(manager.Next(), StartsWith("READY=1\nSTATUS=Listening on 127.0.0.1:"));
  EXPECT_EQ(manager.Next(), "WATCHDOG=1");
  EXPECT_EQ(manager.Next(), "WATCHDOG=1");
  server_->Signal(SIGTERM);
  std::string last = "WATCHDOG=1";
  while (last == "WATCHDOG=1") last = manager.Next();
  EXPECT_EQ(last, "STOPPING=1");
  EXPECT_EQ(server_->Wait(), 0) << server_->Errors();
}

TEST_F(SupervisionTest, AServerThatRanOutOfFilesAndWentDeafEndsAndServesAgain) {
  constexpr int kFiles = 64;
  const int port = Serve(kFiles, "network:\n  listener_watchdog_s: 2\n");
  sockaddr_in address = {};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  address.sin_port = htons(static_cast<uint16_t>(port));
  std::vector<int> silent;
  for (int i = 0; i < 2 * kFiles; ++i) {
    silent.push_back(socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK, 0));
    connect(silent.back(), reinterpret_cast<sockaddr*>(&address), sizeof(address));
  }
  EXPECT_EQ(server_->Wait(), 5) << server_->Errors();
  for (const int file : silent) close(file);
  EXPECT_THAT(server_->Errors(), HasSubstr("no connection was accepted for 2 s"));
  EXPECT_THAT(server_->Errors(), HasSubstr("everything that was acknowledged is stored"));

  EXPECT_NE(Serve(1024, ""), 0);
}

}  // namespace
}  // namespace isthmus
