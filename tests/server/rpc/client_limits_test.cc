// The client library at a server's limits: it comes again when it was asked to, and what is too
// large for a message holds up nothing.
#include <unistd.h>

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "client/library/client.h"
#include "core/codec/payload_builder.h"
#include "tests/server/rpc/rpc_fixture.h"

namespace isthmus::rpc {
namespace {

class OneStreamTest : public RpcTest {
 protected:
  static ServerOptions OneStream() {
    ServerOptions options;
    options.calls.streams_per_caller = 1;
    options.max_receive_bytes = 1 << 16;
    return options;
  }
  OneStreamTest() : RpcTest(OneStream()) {}

  // `on_wait` is called in place of waiting before an attempt that is made again.
  std::unique_ptr<client::Client> Connect(std::function<void(double)> on_wait = [](double) {}) {
    client::ClientOptions options;
    options.address = server_->address();
    options.sleep = std::move(on_wait);
    return *client::Client::Connect(options);
  }
  // More than the server takes, however it is packed.
  static PointPayload Large() {
    PointPayload payload = codec::MakePayload(Cloud(10'000, {1, 2, 3, 4}));
    for (size_t i = 0; i < payload.data.size(); ++i) {
      payload.data[i] = static_cast<char>(i * 2654435761u >> 13);
    }
    return payload;
  }
};

TEST_F(OneStreamTest, ARobotThatIsLocalisedComesAgainWhenItWasAskedTo) {
  // Somebody has the one place.
  const auto context = NewContext();
  const auto holder = stubs_->sessions->StreamScans(context.get());
  v1::StreamScansRequest scan;
  scan.set_session(stubs_->NewSession("alice"));
  scan.mutable_scan()->set_sequence(1);
  ASSERT_TRUE(holder->Write(scan));
  v1::StreamScansResponse ack;
  ASSERT_TRUE(holder->Read(&ack));
  std::vector<double> waits;
  const auto client = Connect([&](double seconds) {
    waits.push_back(seconds);
    if (waits.size() != 2) return;
    holder->WritesDone();
    EXPECT_GRPC_OK(holder->Finish());
  });
  const auto localisation = client->OpenLocalisation({.sensor = "vlp16"});
  const auto located = localisation->Locate(1, codec::MakePayload(Cloud{{1, 2, 3, 4}}));
  // Let in at last, whatever it then hears of the map.
  EXPECT_FALSE(absl::IsResourceExhausted(located.status())) << located.status();
  ASSERT_GE(waits.size(), 2u);
  for (const double wait : waits) EXPECT_GE(wait, 1.0);
}

TEST_F(OneStreamTest, AScanAboveTheLimitNamesTheSetting) {
  const auto client = Connect();
  const auto session = client->CreateSession("alice", "vlp16");
  ASSERT_TRUE(session.ok()) << session.status();
  const auto stream = client->OpenScanStream(session->record.id);
  ASSERT_TRUE(stream.ok()) << stream.status();
  ASSERT_TRUE((*stream)->Push(1, Large()).ok());
  const absl::Status status = (*stream)->Finish();
  EXPECT_TRUE(absl::IsResourceExhausted(status)) << status;
  EXPECT_THAT(std::string(status.message()), testing::HasSubstr("network.max_receive_bytes"));
}

TEST_F(OneStreamTest, OfASpoolItIsSetAsideAndTheRestArrives) {
  client::ScanStreamOptions options;
  options.spool_dir = testing::TempDir() + "isthmus_large_" + std::to_string(getpid());
  const auto client = Connect();
  {
    const auto stream = client->OpenSpool({RobotId("alice"), "vlp16"}, options);
    ASSERT_TRUE(stream.ok()) << stream.status();
    ASSERT_TRUE((*stream)->Push(1, Large()).ok());
    ASSERT_TRUE((*stream)->Push(2, codec::MakePayload(Cloud{{1, 2, 3, 4}})).ok());
    ASSERT_TRUE((*stream)->Finish().ok());
    EXPECT_EQ((*stream)->stats().set_aside, 1u);
    EXPECT_EQ((*stream)->stats().backlog, 0u);
  }
  EXPECT_TRUE(std::filesystem::exists(options.spool_dir + "/too-large/1.scan"));
  std::filesystem::remove_all(options.spool_dir);
}

}  // namespace
}  // namespace isthmus::rpc
