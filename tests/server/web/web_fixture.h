// A server for browsers before one of gRPC over a fake pipeline.
#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "core/concurrency/mutex.h"
#include "core/site_name.h"
#include "server/web/web_server.h"
#include "tests/server/http/conversation.h"
#include "tests/server/rpc/fake_pipeline.h"
#include "tests/server/rpc/stubs.h"

namespace isthmus {

// The files of tests/server/web/page.
const Assets& TestAssets();

}  // namespace isthmus

namespace isthmus::web {

class WebTest : public testing::Test {
 protected:
  WebTest() {
    folder_ = testing::TempDir() + "isthmus-web-XXXXXX";
    if (mkdtemp(folder_.data()) == nullptr) throw std::runtime_error("mkdtemp failed");
    tokens_ = *access::Tokens::Open(folder_);
    options_.listen = "127.0.0.1:0";
    rpc_options_.listen = "127.0.0.1:0";
    rpc_options_.tokens = tokens_.get();
    rpc_options_.token_review_interval = std::chrono::milliseconds(20);
    rpc_options_.on_failed_call = [this](const rpc::FailedCall& call) {
      MutexLock lock(&mutex_);
      failed_.push_back(call);
    };
    rpc_options_.on_ended_call = [this](const std::string& rpc, absl::StatusCode code, double) {
      MutexLock lock(&mutex_);
      ended_.emplace_back(rpc, code);
    };
  }
  ~WebTest() override {
    web_.reset();
    server_.reset();
    std::filesystem::remove_all(folder_);
  }

  void Start() {
    auto server = rpc::RpcServer::Start(&pipeline_, rpc_options_);
    ASSERT_TRUE(server.ok()) << server.status();
    server_ = *std::move(server);
    auto web = WebServer::Start(options_, *server_, TestAssets());
    ASSERT_TRUE(web.ok()) << web.status();
    web_ = *std::move(web);
    address_ = web_->url().substr(std::string("http://").size());
  }
  // The secret of a new token.
  std::string NewToken(const std::string& name, AccessRole role) {
    AccessToken token;
    token.name = name;
    token.role = role;
    token.sites = {kDefaultSite};
    if (role == AccessRole::kRobot) token.robots = {"*"};
    const auto made = tokens_->Create(token);
    EXPECT_TRUE(made.ok()) << made.status();
    return made.ok() ? made->secret : "";
  }
  http::Reply Get(const std::string& target, const std::string& headers = "") const {
    return http::Ask(address_, "GET", target, headers);
  }
  // As JSON.
  http::Reply Post(const std::string& target, const std::string& body,
                   const std::string& headers = "") const {
    return http::Ask(address_, "POST", target, "Content-Type: application/json\r\n" + headers,
                     body);
  }
  http::Reply Call(const std::string& method, const std::string& body = "{}",
                   const std::string& headers = "") const {
    return Post("/rpc/isthmus.v1." + method, body, headers);
  }
  // The request of a stream whose answer is read bit by bit.
  void Begin(http::Conversation* conversation, const std::string& method, const std::string& body,
             const std::string& headers = "") const {
    conversation->Send("POST /rpc/isthmus.v1." + method + " HTTP/1.1\r\nHost: " + address_ +
                       "\r\nContent-Type: application/json\r\nContent-Length: " +
                       std::to_string(body.size()) + "\r\n" + headers + "\r\n" + body);
  }
  std::vector<rpc::FailedCall> failed() {
    MutexLock lock(&mutex_);
    return failed_;
  }
  std::vector<std::pair<std::string, absl::StatusCode>> ended() {
    MutexLock lock(&mutex_);
    return ended_;
  }

  rpc::FakePipeline pipeline_;
  std::string folder_;
  std::unique_ptr<access::Tokens> tokens_;
  rpc::ServerOptions rpc_options_;
  WebOptions options_;
  Mutex mutex_;
  std::vector<rpc::FailedCall> failed_ ABSL_GUARDED_BY(mutex_);
  std::vector<std::pair<std::string, absl::StatusCode>> ended_ ABSL_GUARDED_BY(mutex_);
  std::unique_ptr<rpc::RpcServer> server_;
  std::unique_ptr<WebServer> web_;
  std::string address_;
};

inline std::string Bearer(const std::string& secret) {
  return "Authorization: Bearer " + secret + "\r\n";
}

}  // namespace isthmus::web
