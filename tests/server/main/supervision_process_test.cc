// isthmus-server under a service manager, and with more connections than it may have files.
#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <poll.h>
#include <signal.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "tests/server/main/child_process.h"
#include "tests/server/main/notify_socket.h"
#include "tests/server/rpc/stubs.h"

namespace isthmus {
namespace {

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
  int Serve(int files) {
    server_ = std::make_unique<ChildProcess>(
        "/bin/sh",
        std::vector<std::string>{"-c", "ulimit -n " + std::to_string(files) + "; exec \"$@\"", "sh",
                                 ISTHMUS_SERVER, "--data", folder_ + "/data", "--listen",
                                 "127.0.0.1:0"},
        folder_ + "/stderr");
    const std::string line = server_->ReadLine();
    EXPECT_THAT(line, StartsWith(kListening)) << server_->Errors();
    return line.size() < sizeof(kListening) ? 0 : std::stoi(line.substr(sizeof(kListening) - 1));
  }

  std::string folder_;
  std::unique_ptr<ChildProcess> server_;
};

TEST_F(SupervisionTest, AServiceManagerHearsThatItServesAndThatItEnds) {
  const NotifySocket manager(folder_ + "/notify");
  Serve(1024);
  EXPECT_THAT(manager.Next(), StartsWith("READY=1\nSTATUS=Listening on 127.0.0.1:"));
  EXPECT_EQ(manager.Next(), "WATCHDOG=1");
  EXPECT_EQ(manager.Next(), "WATCHDOG=1");
  server_->Signal(SIGTERM);
  std::string last = "WATCHDOG=1";
  while (last == "WATCHDOG=1") last = manager.Next();
  EXPECT_EQ(last, "STOPPING=1");
  EXPECT_EQ(server_->Wait(), 0) << server_->Errors();
}

// Connections of strangers that have begun to speak, which a server has to take.
class Crowd {
 public:
  Crowd(int port, int size) {
    sockaddr_in address = {};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    address.sin_port = htons(static_cast<uint16_t>(port));
    for (int i = 0; i < size; ++i) {
      const int file = socket(AF_INET, SOCK_STREAM, 0);
      files_.push_back(file);
      if (connect(file, reinterpret_cast<sockaddr*>(&address), sizeof(address)) != 0) continue;
      (void)send(file, "P", 1, MSG_NOSIGNAL);
    }
  }
  ~Crowd() {
    for (const int file : files_) close(file);
  }
  // Waits for one that the server closes.
  bool WaitUntilOneIsRefused() const {
    std::vector<pollfd> ends;
    for (const int file : files_) ends.push_back({file, POLLIN | POLLRDHUP, 0});
    return poll(ends.data(), ends.size(), 30'000) > 0;
  }

 private:
  std::vector<int> files_;
};

TEST_F(SupervisionTest, ACrowdOfConnectionsKeepsNobodyOutForGoodAndNoFileFromTheMap) {
  constexpr int kFiles = 64;
  const std::string address = "127.0.0.1:" + std::to_string(Serve(kFiles));
  const auto connect = [&] {
    grpc::ChannelArguments own;
    own.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
    return rpc::Stubs(grpc::CreateCustomChannel(address, grpc::InsecureChannelCredentials(), own));
  };
  rpc::Stubs before = connect();
  EXPECT_FALSE(before.NewSession("alice").empty());
  {
    const Crowd crowd(std::stoi(address.substr(address.rfind(':') + 1)), 2 * kFiles);
    EXPECT_TRUE(crowd.WaitUntilOneIsRefused());
    EXPECT_FALSE(before.NewSession("bob").empty());
  }
  rpc::Stubs after = connect();
  const auto context = rpc::NewContext();
  context->set_wait_for_ready(true);
  v1::MapInfo info;
  EXPECT_GRPC_OK(after.map->GetMapInfo(context.get(), {}, &info));
  server_->Signal(SIGTERM);
  EXPECT_EQ(server_->Wait(), 0) << server_->Errors();
}

}  // namespace
}  // namespace isthmus
