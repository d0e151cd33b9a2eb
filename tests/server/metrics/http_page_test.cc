// The page over HTTP: it answers the right requests, and nothing that a content does ends the
// server.
#include "server/metrics/http_page.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <new>
#include <stdexcept>
#include <string>
#include <vector>

#include "tests/server/metrics/scrape.h"

namespace isthmus::metrics {
namespace {

using testing::EndsWith;
using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;

std::unique_ptr<http::Listener> Serve(PageContent content) {
  return ServePage("localhost:0", "text/plain", std::move(content)).value();
}

TEST(HttpPageTest, GetAndHeadOfThePageAreAnsweredAndNothingElse) {
  const auto page = Serve([] { return std::string("content 1\n"); });
  const std::string answer = Ask(page->address(), "GET /metrics");
  EXPECT_THAT(answer, StartsWith("HTTP/1.1 200"));
  EXPECT_THAT(answer, HasSubstr("Content-Type: text/plain\r\n"));
  EXPECT_THAT(answer, EndsWith("\r\n\r\ncontent 1\n"));
  EXPECT_THAT(Ask(page->address(), "GET /metrics?name=x"), EndsWith("content 1\n"));
  const std::string head = Ask(page->address(), "HEAD /metrics");
  EXPECT_THAT(head, StartsWith("HTTP/1.1 200"));
  EXPECT_THAT(head, Not(HasSubstr("content 1")));
  EXPECT_THAT(Ask(page->address(), "POST /metrics"), StartsWith("HTTP/1.1 405"));
  EXPECT_THAT(Ask(page->address(), "PUT /new"), StartsWith("HTTP/1.1 404"));
  for (const char* path : {"/", "/metrics/x", "/../../etc/passwd", "/etc/passwd", "/%2e%2e/etc"}) {
    const std::string refused = Ask(page->address(), std::string("GET ") + path);
    EXPECT_THAT(refused, StartsWith("HTTP/1.1 4")) << path;
    EXPECT_THAT(refused, Not(HasSubstr("root:"))) << path;
  }
}

TEST(HttpPageTest, WhatTheContentThrowsIsTheAnswerToThatRequestAlone) {
  int asked = 0;
  const auto page = Serve([&]() -> std::string {
    if (++asked == 1) throw std::bad_alloc();
    if (asked == 2) throw std::runtime_error("%s broken");
    return "well again\n";
  });
  EXPECT_THAT(Ask(page->address(), "GET /metrics"), StartsWith("HTTP/1.1 500"));
  const std::string broken = Ask(page->address(), "GET /metrics");
  EXPECT_THAT(broken, StartsWith("HTTP/1.1 500"));
  EXPECT_THAT(broken, HasSubstr("%s broken"));
  EXPECT_THAT(Ask(page->address(), "GET /metrics"), EndsWith("well again\n"));
}

TEST(HttpPageTest, AnAddressInUseOrOfNoOneIsAnError) {
  const auto page = Serve([] { return std::string(); });
  for (const std::string& taken : {page->address(), std::string("192.0.2.1:9464")}) {
    const auto second = ServePage(taken, "text/plain", [] { return std::string(); });
    EXPECT_TRUE(absl::IsUnavailable(second.status())) << second.status();
    EXPECT_THAT(std::string(second.status().message()), HasSubstr(taken));
  }
}

TEST(HttpPageTest, ConnectionsThatSayNothingKeepNobodyOut) {
  const auto page = Serve([] { return std::string("content\n"); });
  const int port = std::stoi(page->address().substr(page->address().rfind(':') + 1));
  std::vector<int> silent(50);
  for (int& file : silent) {
    file = socket(AF_INET, SOCK_STREAM, 0);
    sockaddr_in address = {};
    address.sin_family = AF_INET;
    address.sin_port = htons(static_cast<uint16_t>(port));
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    ASSERT_EQ(connect(file, reinterpret_cast<sockaddr*>(&address), sizeof(address)), 0);
  }
  EXPECT_THAT(Ask(page->address(), "GET /metrics"), EndsWith("content\n"));
  for (const int file : silent) close(file);
}

TEST(HttpPageTest, AfterItIsGoneNobodyAnswers) {
  auto page = Serve([] { return std::string("content\n"); });
  const std::string address = page->address();
  page = nullptr;
  EXPECT_EQ(Ask(address, "GET /metrics"), "");
}

}  // namespace
}  // namespace isthmus::metrics
