// The effect of a lost link on a robot's scans: none.
#include "client/library/stream/scan_stream.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <future>
#include <numeric>

#include "api/convert/cloud.h"
#include "client/library/client.h"
#include "core/codec/payload_builder.h"
#include "core/codec/quantized.h"
#include "tests/client/library/fake_server.h"
#include "tests/core/codec/payloads.h"

namespace isthmus::client {
namespace {

using testing::HasSubstr;

class ScanStreamTest : public testing::Test {
 protected:
  void SetUp() override {
    ClientOptions options;
    options.address = server_.address();
    options.sleep = [this](double) { ++waits_; };
    options.backoff.max_attempts = 4;
    auto client = Client::Connect(options);
    ASSERT_TRUE(client.ok()) << client.status();
    client_ = std::move(*client);
  }

  std::unique_ptr<ScanStream> Open(ScanStreamOptions options = {}) {
    options.on_ack = [this](const ScanAck& ack) { acks_.push_back(ack); };
    auto stream = client_->OpenScanStream(SessionId("alice-1"), options);
    EXPECT_TRUE(stream.ok()) << stream.status();
    return std::move(*stream);
  }

  static void Push(ScanStream& stream, int scans) {
    const PointPayload payload = codec::MakePayload(Cloud{{1, 2, 3, 4}});
    for (int i = 1; i <= scans; ++i) ASSERT_TRUE(stream.Push(100 * i, payload).ok());
  }

  static std::vector<uint64_t> UpTo(uint64_t n) {
    std::vector<uint64_t> sequences(n);
    std::iota(sequences.begin(), sequences.end(), 1);
    return sequences;
  }

  // Every scan was acknowledged once, in order, with its own stamp.
  void ExpectAcks(uint64_t n) const {
    ASSERT_EQ(acks_.size(), n);
    for (uint64_t i = 1; i <= n; ++i) {
      EXPECT_EQ(acks_[i - 1].sequence, i);
      EXPECT_EQ(acks_[i - 1].end_stamp_ns, static_cast<int64_t>(100 * i));
    }
  }

  FakeServer server_;
  std::atomic<int> waits_{0};
  std::unique_ptr<Client> client_;
  std::vector<ScanAck> acks_;
};

TEST_F(ScanStreamTest, EveryScanIsAcknowledgedOnceAndInOrder) {
  auto stream = Open({.window = 4});
  Push(*stream, 50);
  ASSERT_TRUE(stream->Finish().ok());
  ExpectAcks(50);
  EXPECT_EQ(server_.sessions.effects(), UpTo(50));
  EXPECT_EQ(stream->stats().processed, 50u);
}

// A scan of a spinning sensor, for a server that does not read what clients write today.
TEST_F(ScanStreamTest, AnOlderServerGetsTheSamePointsAsItReadsThem) {
  const PointPayload raw = codec::MakePayload(codec::RoomScan(), true, true);
  std::vector<PointPayload> arrived;
  for (const uint32_t version : {0u, 1u, 2u}) {
    server_.sessions.quantized_version = version;
    auto stream = Open({.resolution_m = 0.002});
    ASSERT_TRUE(stream->Push(100 * (version + 1), raw).ok());
    ASSERT_TRUE(stream->Finish().ok());
    auto cloud = convert::FromMessage(server_.sessions.last_cloud());
    ASSERT_TRUE(cloud.ok()) << cloud.status();
    EXPECT_EQ(codec::QuantizedVersionOf(*cloud), std::max<int>(1, version));
    const auto points = codec::Dequantize(*cloud);
    ASSERT_TRUE(points.ok()) << points.status();
    arrived.push_back(*points);
  }
  EXPECT_EQ(arrived[0].data, arrived[2].data);
  EXPECT_EQ(arrived[1].data, arrived[2].data);
}

TEST_F(ScanStreamTest, ALostLinkLosesAndDoublesNothing) {
  server_.sessions.break_after = 10;
  auto stream = Open();
  Push(*stream, 30);
  ASSERT_TRUE(stream->Finish().ok());
  ExpectAcks(30);
  EXPECT_EQ(server_.sessions.effects(), UpTo(30));
  EXPECT_EQ(stream->stats().reconnects, 1);
  EXPECT_EQ(waits_, 1);
}

TEST_F(ScanStreamTest, ScansWhoseAcknowledgementWasLostComeBackAsDuplicates) {
  server_.sessions.swallow_acks = 3;
  server_.sessions.break_after = 10;
  auto stream = Open();
  Push(*stream, 20);
  ASSERT_TRUE(stream->Finish().ok());
  ExpectAcks(20);
  EXPECT_EQ(server_.sessions.effects(), UpTo(20));
  EXPECT_EQ(stream->stats().duplicates, 3u);
  EXPECT_EQ(stream->stats().processed, 17u);
}

TEST_F(ScanStreamTest, SendsAgainWhatTheServerForgotInACrash) {
  server_.sessions.forget_from = 4;  // Scans 4 to 10 were acknowledged but not durable.
  server_.sessions.break_after = 10;
  auto stream = Open();
  Push(*stream, 20);
  ASSERT_TRUE(stream->Finish().ok());
  ExpectAcks(20);
  EXPECT_EQ(server_.sessions.effects(), UpTo(20));
}

TEST_F(ScanStreamTest, SaysThatTooFewScansWereKeptForWhatTheServerForgot) {
  server_.sessions.forget_from = 1;
  server_.sessions.break_after = 10;
  auto stream = Open({.window = 2, .spool_bytes = 64});  // Some four.
  Push(*stream, 8);
  const PointPayload payload = codec::MakePayload(Cloud{{1, 2, 3, 4}});
  for (int i = 9; i <= 20 && stream->Push(100 * i, payload).ok(); ++i) continue;
  const absl::Status status = stream->Finish();
  EXPECT_TRUE(absl::IsFailedPrecondition(status)) << status;
  EXPECT_THAT(std::string(status.message()), HasSubstr("spool_bytes"));
}

TEST_F(ScanStreamTest, SendsAgainWhatTheServerForgotWhileItFinished) {
  server_.sessions.forget_at_finish = 4;
  auto stream = Open();
  Push(*stream, 20);
  const auto session = stream->FinishSession();
  ASSERT_TRUE(session.ok()) << session.status();
  EXPECT_EQ(session->durable_sequence, 20u);
  ExpectAcks(20);
  EXPECT_EQ(server_.sessions.effects(), UpTo(20));
  EXPECT_EQ(stream->stats().reconnects, 1);
}

TEST_F(ScanStreamTest, FinishesTheSessionAlsoAfterItWasFinishedWithout) {
  auto stream = Open();
  Push(*stream, 3);
  ASSERT_TRUE(stream->Finish().ok());
  EXPECT_EQ(server_.sessions.finishes, 0);
  for (int k = 0; k < 2; ++k) {
    const auto session = stream->FinishSession();
    ASSERT_TRUE(session.ok()) << session.status();
    EXPECT_EQ(session->durable_sequence, 3u);
  }
  EXPECT_EQ(server_.sessions.finishes, 1);
}

TEST_F(ScanStreamTest, AServerThatIsStoppedWhileItFinishesIsAskedAgain) {
  server_.sessions.stops_at_finish = true;
  auto stream = Open();
  Push(*stream, 3);
  const auto session = stream->FinishSession();
  ASSERT_TRUE(session.ok()) << session.status();
  EXPECT_EQ(session->durable_sequence, 3u);
  EXPECT_EQ(waits_, 1);
}

TEST_F(ScanStreamTest, AServerThatHangsWhileItFinishesIsWaitedForOnce) {
  server_.sessions.hangs_at_finish = true;
  ClientOptions options;
  options.address = server_.address();
  options.sleep = [this](double) { ++waits_; };
  options.transfer_timeout_s = 0.2;
  const auto client = Client::Connect(options);
  ASSERT_TRUE(client.ok()) << client.status();
  const auto stream = (*client)->OpenScanStream(SessionId("alice-1"));
  ASSERT_TRUE(stream.ok()) << stream.status();
  Push(**stream, 3);
  const auto session = (*stream)->FinishSession();
  EXPECT_TRUE(absl::IsDeadlineExceeded(session.status())) << session.status();
  EXPECT_EQ(waits_, 0);
}

// As where a server was started with another folder, and another program was there first.
TEST_F(ScanStreamTest, AnotherSessionOfTheNameIsNotTakenForItsOwn) {
  auto stream = Open();
  Push(*stream, 20);
  ASSERT_TRUE(stream->Finish().ok());
  server_.sessions.created_ns = 2;
  const auto session = stream->FinishSession();
  EXPECT_TRUE(absl::IsNotFound(session.status())) << session.status();
  EXPECT_THAT(std::string(session.status().message()), HasSubstr("is another one now"));
  EXPECT_EQ(server_.sessions.finishes, 0);
}

TEST_F(ScanStreamTest, GoesOnBehindTheScansOfAnEarlierProgram) {
  server_.sessions.taken_up = 7;
  auto stream = Open();
  Push(*stream, 2);
  ASSERT_TRUE(stream->Finish().ok());
  EXPECT_EQ(server_.sessions.effects(), (std::vector<uint64_t>{8, 9}));
}

TEST_F(ScanStreamTest, ScansOfOthersInTheSessionAreFoundOut) {
  server_.sessions.break_after = 10;
  server_.sessions.others_at_break = 100;
  auto stream = Open();
  Push(*stream, 10);
  const absl::Status status = stream->Finish();
  EXPECT_TRUE(absl::IsFailedPrecondition(status)) << status;
  EXPECT_THAT(std::string(status.message()), HasSubstr("another program"));
}

TEST_F(ScanStreamTest, GoesOnAtTheNextServerBehindWhatThatHas) {
  FakeServer next;
  ClientOptions options;
  options.address = server_.address() + "," + next.address();
  options.sleep = [](double) {};
  const auto client = Client::Connect(options);
  ASSERT_TRUE(client.ok()) << client.status();
  std::vector<ScanAck> acks;
  auto stream = (*client)->OpenScanStream(
      SessionId("alice-1"), {.on_ack = [&](const ScanAck& ack) { acks.push_back(ack); }});
  ASSERT_TRUE(stream.ok()) << stream.status();
  server_.sessions.break_after = 10;  // Nothing that it acknowledged was durable.
  Push(**stream, 30);
  ASSERT_TRUE((*stream)->Finish().ok());
  EXPECT_EQ(acks.size(), 30u);
  EXPECT_EQ(server_.sessions.effects(), UpTo(10));
  EXPECT_EQ(next.sessions.effects(), UpTo(30));
}

TEST_F(ScanStreamTest, GivesUpWhenTheServerStaysAway) {
  auto server = std::make_unique<FakeServer>();
  ClientOptions options;
  options.address = server->address();
  options.backoff.max_attempts = 3;
  options.sleep = [this](double) { ++waits_; };
  auto client = Client::Connect(options);
  ASSERT_TRUE(client.ok());
  std::promise<void> first_ack;
  auto stream = (*client)->OpenScanStream(
      SessionId("alice-1"), {.on_ack = [&](const ScanAck&) { first_ack.set_value(); }});
  ASSERT_TRUE(stream.ok());
  Push(**stream, 1);
  first_ack.get_future().wait();
  server.reset();
  const absl::Status status = (*stream)->Finish();
  EXPECT_TRUE(absl::IsUnavailable(status)) << status;
  EXPECT_THAT(std::string(status.message()), HasSubstr("cannot reach isthmus-server at"));
  EXPECT_EQ(waits_, 2);
}

TEST_F(ScanStreamTest, AnUnknownSessionIsToldAtOnce) {
  const auto stream = client_->OpenScanStream(SessionId("nobody-1"));
  EXPECT_TRUE(absl::IsNotFound(stream.status())) << stream.status();
  EXPECT_EQ(waits_, 0);
}

TEST_F(ScanStreamTest, ACloudThatCannotBeCompressedIsRefusedAndTheStreamGoesOn) {
  auto stream = Open({.resolution_m = 0.002});
  PointPayload lying = codec::MakePayload(Cloud{{1, 2, 3, 4}});
  lying.width = 1000;
  EXPECT_TRUE(absl::IsInvalidArgument(stream->Push(1, lying)));
  Push(*stream, 3);
  ASSERT_TRUE(stream->Finish().ok());
  ExpectAcks(3);
}

TEST_F(ScanStreamTest, PushAfterFinishIsRefused) {
  auto stream = Open();
  ASSERT_TRUE(stream->Finish().ok());
  EXPECT_TRUE(absl::IsFailedPrecondition(stream->Push(1, codec::MakePayload(Cloud{{}}))));
  EXPECT_TRUE(stream->Finish().ok()) << "twice is no error";
}

TEST_F(ScanStreamTest, CanBeGivenUpWithScansUnderWay) {
  auto stream = Open();
  Push(*stream, 5);
  stream.reset();  // Must return.
  EXPECT_LE(acks_.size(), 5u);
}

}  // namespace
}  // namespace isthmus::client
