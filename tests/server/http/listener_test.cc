// The listener over real sockets: the requests that it hands over, and clients that cannot harm it.
#include "server/http/listener.h"

#include <absl/synchronization/notification.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <memory>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>

#include "tests/server/http/conversation.h"

namespace isthmus::http {
namespace {

using std::chrono::milliseconds;
using testing::HasSubstr;
using testing::StartsWith;

const std::string kGet("GET / HTTP/1.1\r\nHost: a\r\n\r\n");
constexpr absl::Duration kLong = absl::Seconds(20);

class ListenerTest : public testing::Test {
 protected:
  ListenerTest() {
    options_.listen = "127.0.0.1:0";
    options_.setting = "test.listen";
  }
  void Start(Listener::Handler handler) {
    auto started = Listener::Start(options_, std::move(handler));
    ASSERT_TRUE(started.ok()) << started.status();
    listener_ = *std::move(started);
    address_ = listener_->address();
  }

  ListenerOptions options_;
  std::unique_ptr<Listener> listener_;
  std::string address_;
};

// Pieces of 64 KiB without end; tells when it goes.
class EndlessSource final : public Source {
 public:
  explicit EndlessSource(absl::Notification* gone) : gone_(gone) {}
  ~EndlessSource() override { gone_->Notify(); }
  Next Take(std::string* piece) override {
    piece->assign(size_t{64} << 10, 'x');
    return Next::kPiece;
  }

 private:
  absl::Notification* const gone_;
};

class TwoPieces final : public Source {
 public:
  explicit TwoPieces(Next end) : end_(end) {}
  Next Take(std::string* piece) override {
    if (taken_ == 2) return end_;
    *piece = ++taken_ == 1 ? "one " : "two";
    return Next::kPiece;
  }

 private:
  const Next end_;
  int taken_ = 0;
};

TEST_F(ListenerTest, AHandlerSeesWhatWasAsked) {
  Request seen;
  Start([&](const Request& request) {
    seen = request;
    return Text(200, "done");
  });
  const Reply reply = Ask(address_, "POST", "/a%20b/..?x=1%262&y",
                          "X-One: 1\r\nx-one: 2\r\nCookie: a=b; token=c=d\r\n", "the body");
  EXPECT_EQ(reply.code, 200);
  EXPECT_EQ(reply.body, "done");
  EXPECT_EQ(seen.method, "POST");
  EXPECT_EQ(seen.path, "/a b/..");
  EXPECT_EQ(seen.Query("x"), "1&2");
  EXPECT_EQ(seen.Query("y"), "");
  EXPECT_EQ(seen.Query("z"), std::nullopt);
  EXPECT_EQ(seen.Header("X-ONE"), "1, 2");
  EXPECT_EQ(seen.Cookie("token"), "c=d");
  EXPECT_EQ(seen.Cookie("a"), "b");
  EXPECT_EQ(seen.Cookie("oken"), std::nullopt);
  EXPECT_EQ(seen.body, "the body");
  EXPECT_THAT(seen.peer, StartsWith("ipv4:127.0.0.1:"));
  EXPECT_FALSE(seen.is_tls);
}

TEST_F(ListenerTest, AConnectionCarriesSeveralRequests) {
  std::atomic<int> asked = 0;
  Start([&](const Request&) { return Text(200, std::to_string(++asked)); });
  Conversation conversation(address_);
  for (const char* number : {"1", "2", "3"}) {
    conversation.Send(kGet);
    EXPECT_THAT(conversation.ReadUntil(std::string("\r\n\r\n") + number), HasSubstr("200 OK"));
  }
}

TEST_F(ListenerTest, ASourceIsSentToItsEndAndABrokenOneIsCutOff) {
  Start([](const Request& request) {
    Response response;
    response.source = std::make_unique<TwoPieces>(request.path == "/whole" ? Source::Next::kEnd
                                                                           : Source::Next::kBroken);
    return response;
  });
  const Reply whole = Ask(address_, "GET", "/whole"), broken = Ask(address_, "GET", "/broken");
  EXPECT_EQ(whole.body, "one two");
  EXPECT_TRUE(whole.is_whole);
  EXPECT_EQ(broken.code, 200);
  EXPECT_FALSE(broken.is_whole);
}

TEST_F(ListenerTest, WhatAHandlerThrowsIsTheAnswerToThatRequestAlone) {
  std::atomic<int> asked = 0;
  Start([&](const Request&) -> Response {
    if (++asked == 1) throw std::runtime_error("%s broken");
    return Text(200, "well again");
  });
  const Reply thrown = Ask(address_, "GET", "/");
  EXPECT_EQ(thrown.code, 500);
  EXPECT_THAT(thrown.body, HasSubstr("%s broken"));
  EXPECT_EQ(Ask(address_, "GET", "/").body, "well again");
}

TEST_F(ListenerTest, LargeRequestsAreRefusedAndOthersServed) {
  options_.max_body = 1000;
  std::atomic<int> asked = 0;
  Start([&](const Request& request) {
    ++asked;
    return Text(200, std::to_string(request.body.size()));
  });
  EXPECT_EQ(Ask(address_, "POST", "/", "", std::string(1000, 'a')).body, "1000");
  EXPECT_EQ(Ask(address_, "POST", "/", "", std::string(1001, 'a')).code, 413);
  Conversation untold(address_);  // A body whose length it does not say.
  untold.Send("POST / HTTP/1.1\r\nHost: a\r\nTransfer-Encoding: chunked\r\n\r\n7d0\r\n" +
              std::string(2000, 'a') + "\r\n0\r\n\r\n");
  EXPECT_EQ(untold.ReadAll(), "");
  const Reply headers = Ask(address_, "GET", "/", "X: " + std::string(1 << 20, 'a') + "\r\n");
  EXPECT_TRUE(headers.code == 0 || headers.code >= 400) << headers.code;
  const Reply path = Ask(address_, "GET", "/" + std::string(1 << 20, 'a'));
  EXPECT_TRUE(path.code == 0 || path.code >= 400) << path.code;
  EXPECT_EQ(asked, 1);
  EXPECT_EQ(Ask(address_, "GET", "/").code, 200);
}

TEST_F(ListenerTest, NonsenseIsRefusedAndOthersServed) {
  Start([](const Request&) { return Text(200, ""); });
  for (const std::string& nonsense :
       {std::string("\x16\x03\x01\x02\x00\x01\x00", 7), std::string(1000, '\0'),
        std::string("GET\r\n\r\n"), std::string("GET / HTTP/9.9\r\nHost: a\r\n\r\n"),
        std::string("POST / HTTP/1.1\r\nHost: a\r\nContent-Length: -1\r\n\r\n"),
        std::string("POST / HTTP/1.1\r\nHost: a\r\nContent-Length: 99999999999999999999\r\n\r\n"),
        std::string("POST / HTTP/1.1\r\nHost: a\r\nTransfer-Encoding: chunked\r\n\r\nzz\r\n")}) {
    Conversation conversation(address_);
    conversation.Send(nonsense);
    conversation.HangUp();
    EXPECT_EQ(Ask(address_, "GET", "/").code, 200) << nonsense;
  }
}

TEST_F(ListenerTest, WhoSaysHalfARequestIsCutOff) {
  options_.request_time = milliseconds(300);
  Start([](const Request&) { return Text(200, ""); });
  Conversation headers(address_), body(address_), idle(address_);
  headers.Send("GET / HTTP/1.1\r\nHost: a\r\nX-");
  body.Send("POST / HTTP/1.1\r\nHost: a\r\nContent-Length: 10\r\n\r\nhalf");
  idle.Send(kGet);
  EXPECT_EQ(headers.ReadAll(), "");
  EXPECT_EQ(body.ReadAll(), "");
  EXPECT_THAT(idle.ReadAll(), HasSubstr("200 OK"));  // And then nothing more to say.
}

TEST_F(ListenerTest, WhoDoesNotReadIsCutOff) {
  options_.piece_time = milliseconds(300);
  absl::Notification gone;
  Start([&](const Request&) {
    Response response;
    response.source = std::make_unique<EndlessSource>(&gone);
    return response;
  });
  Conversation conversation(address_);
  conversation.Send(kGet);
  EXPECT_TRUE(gone.WaitForNotificationWithTimeout(kLong));
}

TEST_F(ListenerTest, AHandlerLearnsThatItsClientIsGone) {
  absl::Notification begun, noticed;
  Start([&](const Request& request) {
    begun.Notify();
    while (!request.gone()) std::this_thread::yield();
    noticed.Notify();
    return Text(200, "");
  });
  Conversation conversation(address_);
  conversation.Send(kGet);
  EXPECT_TRUE(begun.WaitForNotificationWithTimeout(kLong));
  EXPECT_FALSE(noticed.HasBeenNotified());
  conversation.HangUp();
  EXPECT_TRUE(noticed.WaitForNotificationWithTimeout(kLong));
}

TEST_F(ListenerTest, StoppingEndsWhatIsUnderWay) {
  absl::Notification begun, gone;
  Start([&](const Request& request) {
    if (request.path == "/waits") {
      begun.Notify();
      while (!request.gone()) std::this_thread::yield();
      return Text(200, "");
    }
    Response response;
    response.source = std::make_unique<EndlessSource>(&gone);
    return response;
  });
  Conversation waits(address_), reads(address_);
  waits.Send("GET /waits HTTP/1.1\r\nHost: a\r\n\r\n");
  reads.Send(kGet);
  EXPECT_TRUE(begun.WaitForNotificationWithTimeout(kLong));
  EXPECT_THAT(reads.ReadUntil("\r\n\r\n"), HasSubstr("200 OK"));
  listener_.reset();
  EXPECT_TRUE(gone.HasBeenNotified());
  EXPECT_EQ(Ask(address_, "GET", "/").code, 0);
}

TEST_F(ListenerTest, OneMachineHasItsShareOfConnectionsAlone) {
  options_.connections_per_address = 2;
  Start([](const Request&) { return Text(200, ""); });
  Conversation one(address_), two(address_), three(address_);
  one.Send(kGet);
  EXPECT_THAT(one.ReadUntil("\r\n\r\n"), HasSubstr("200 OK"));
  two.Send(kGet);
  EXPECT_THAT(two.ReadUntil("\r\n\r\n"), HasSubstr("200 OK"));
  three.Send(kGet);
  EXPECT_EQ(three.ReadAll(), "");
}

TEST_F(ListenerTest, AnAddressInUseOrOfNoOneIsAnError) {
  Start([](const Request&) { return Text(200, ""); });
  for (const std::string& taken : {address_, std::string("192.0.2.1:9464")}) {
    options_.listen = taken;
    const auto second = Listener::Start(options_, [](const Request&) { return Text(200, ""); });
    EXPECT_TRUE(absl::IsUnavailable(second.status())) << second.status();
    EXPECT_THAT(std::string(second.status().message()), HasSubstr(taken));
    EXPECT_THAT(std::string(second.status().message()), HasSubstr("test.listen"));
  }
}

}  // namespace
}  // namespace isthmus::http
