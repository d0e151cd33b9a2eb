// isthmus-server as a process that browsers ask, and the settings with which it does not start.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <filesystem>
#include <fstream>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "tests/server/http/conversation.h"
#include "tests/server/main/child_process.h"

namespace isthmus {
namespace {

using testing::HasSubstr;

class WebProcessTest : public testing::Test {
 protected:
  WebProcessTest() {
    folder_ = testing::TempDir() + "isthmus-web-process-XXXXXX";
    if (mkdtemp(folder_.data()) == nullptr) throw std::runtime_error("mkdtemp failed");
  }
  ~WebProcessTest() override {
    server_.reset();
    std::filesystem::remove_all(folder_);
  }

  void Start(const std::string& settings) {
    const std::string path = folder_ + "/server.yaml";
    std::ofstream(path) << settings;
    server_ = std::make_unique<ChildProcess>(
        ISTHMUS_SERVER,
        std::vector<std::string>{"--data", folder_ + "/data", "--listen", "127.0.0.1:0", "--config",
                                 path},
        folder_ + "/stderr");
  }
  // The process's web address, as its log says; it listens.
  std::string Address() const {
    const std::string log = server_->Errors(), begin = "web at http://";
    const size_t at = log.find(begin), end = log.find('\n', at);
    if (at == std::string::npos) return "";
    return log.substr(at + begin.size(), end - at - begin.size());
  }

  std::string folder_;
  std::unique_ptr<ChildProcess> server_;
};

TEST_F(WebProcessTest, BrowsersAreServedUntilTheServerStopsAndTheirStreamsEndWithIt) {
  Start("web: {listen: 'localhost:0'}\n");
  EXPECT_THAT(server_->ReadLine(), HasSubstr("listening")) << server_->Errors();
  const std::string address = Address();
  ASSERT_NE(address, "") << server_->Errors();
  const std::string json = "Content-Type: application/json\r\n";
  const http::Reply status =
      http::Ask(address, "POST", "/rpc/isthmus.v1.AdminService/GetStatus", json, "{}");
  EXPECT_EQ(status.code, 200);
  EXPECT_THAT(status.body, HasSubstr("\"webAddress\":\"http://" + address + "\""));
  http::Conversation conversation(address);
  conversation.Send("POST /rpc/isthmus.v1.EventService/WatchEvents HTTP/1.1\r\nHost: " + address +
                    "\r\nContent-Length: 2\r\n" + json + "\r\n{}");
  EXPECT_THAT(conversation.ReadUntil("\r\n\r\n"), HasSubstr("200 OK"));
  server_->Signal(SIGTERM);
  EXPECT_EQ(server_->Wait(), 0) << server_->Errors();
  conversation.ReadAll();  // The answer ends.
  EXPECT_EQ(http::Ask(address, "GET", "/healthz").code, 0);
}

TEST_F(WebProcessTest, APortInUseEndsTheStart) {
  Start("web: {listen: '127.0.0.1:0'}\nmetrics: {listen: '127.0.0.1:0'}\n");
  EXPECT_THAT(server_->ReadLine(), HasSubstr("listening")) << server_->Errors();
  const auto first = std::move(server_);
  const std::string log = first->Errors(), begin = "web at http://";
  const size_t at = log.find(begin) + begin.size();
  const std::string address = log.substr(at, log.find('\n', at) - at);
  folder_ += "/other";
  std::filesystem::create_directories(folder_);
  Start("web: {listen: '" + address + "'}\n");
  EXPECT_EQ(server_->Wait(), 4);
  EXPECT_THAT(server_->Errors(), HasSubstr("cannot listen at " + address));
  EXPECT_THAT(server_->Errors(), HasSubstr("web.listen"));
}

TEST_F(WebProcessTest, OtherMachinesAreLetInOverTlsOrWhereTheSettingsSaySo) {
  Start("web: {listen: '0.0.0.0:0'}\n");
  EXPECT_EQ(server_->Wait(), 2);
  EXPECT_THAT(server_->Errors(), HasSubstr("web.insecure: true"));
  Start("web: {listen: '0.0.0.0:0', insecure: true}\n");
  EXPECT_THAT(server_->ReadLine(), HasSubstr("listening")) << server_->Errors();
}

}  // namespace
}  // namespace isthmus
